// chi2 of a pose graph: the sum of e' Omega e over edges and priors, without the factor 1/2 of a
// Ceres cost. Costs of two programs compare only when their poses go through one evaluator and one
// error convention: this is that evaluator.
#pragma once

#include <vector>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/pose_graph.h"

namespace ceres {
class LossFunction;
}

namespace hpgo {

struct Chi2Options {
  ceres_costs::ErrorConvention convention = ceres_costs::ErrorConvention::kG2o;
  // Robust loss rho(s) of s = e' Omega e, for Chi2Report::robust_total; null: rho(s) = s. Not
  // owned.
  const ceres::LossFunction* loss = nullptr;
  // The loss applies to loop closures only (hpgo/graph/edge_classes.h), as a solve does by default;
  // false: to every edge. Priors are never robust.
  bool loss_on_closures_only = true;
};

struct Chi2Report {
  std::vector<double> edges;   // e' Omega e, parallel to graph.edges()
  std::vector<double> priors;  // parallel to graph.priors()
  double edge_total = 0;
  double prior_total = 0;
  double total = 0;         // edge_total + prior_total
  double robust_total = 0;  // the same with the loss; equals total without one
};

// At the poses as they stand: a node without a pose counts at the pose it holds. Not a number where
// a pose or a measurement is not one. Thread-safe on a graph that nobody changes.
template <typename G>
Chi2Report EvaluateChi2(const PoseGraph<G>& graph, const Chi2Options& options = Chi2Options());

// e' Omega e of one edge, and of one prior.
template <typename G>
double EdgeChi2(const PoseGraph<G>& graph, const GraphEdge<G>& edge,
                ceres_costs::ErrorConvention convention);
template <typename G>
double PriorChi2(const PoseGraph<G>& graph, const GraphPrior<G>& prior,
                 ceres_costs::ErrorConvention convention);

struct WorstEdge {
  int edge = 0;  // index into graph.edges()
  double chi2 = 0;
};

// The `count` largest of Chi2Report::edges (all of them if there are fewer), largest first; NaN
// counts as larger than any number, equal values keep the order of their edges.
std::vector<WorstEdge> WorstEdges(const std::vector<double>& edge_chi2, int count);

}  // namespace hpgo
