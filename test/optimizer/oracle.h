// What incremental results are compared with: a full optimization of the same
// graph.
#pragma once

#include <string>

#include "gtest/gtest.h"
#include "hpgo/optimizer.h"
#include "hpgo/solve/full_solve.h"

namespace hpgo {

template <typename G>
struct Optimum {
  PoseGraph<G> graph;
  double cost = 0;
};

// The optimum of the optimizer's graph that is nearest to its estimate. `loss`
// is that of every edge (ToGraph does not hold them).
template <typename G>
Optimum<G> OptimumFrom(const Optimizer<G>& optimizer, const std::string& loss = "none",
                       double loss_scale = 1) {
  Optimum<G> optimum;
  optimum.graph = optimizer.ToGraph();
  FullSolveOptions options;
  options.init = InitMethod::kFile;
  options.engine = Engine::kBlock;
  options.convention = optimizer.options().convention;
  options.loss = loss;
  options.loss_scale = loss_scale;
  options.loss_on = LossScope::kAllEdges;
  options.function_tolerance = 1e-12;
  const FullSolveReport report = SolveFull(options, &optimum.graph);
  EXPECT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_NEAR(report.cost_before, optimizer.Cost(), 1e-6 + 1e-7 * report.cost_before);
  optimum.cost = report.cost_after;
  return optimum;
}

// How far the cost is above the optimum's, relative to it.
template <typename G>
double Gap(const Optimizer<G>& optimizer) {
  return optimizer.Cost() / OptimumFrom(optimizer).cost - 1;
}

// The largest difference of the relative pose along an edge: poses compared
// without a gauge.
template <typename G>
double LargestRelativeDifference(const PoseGraph<G>& a, const PoseGraph<G>& b) {
  double largest = 0;
  for (const GraphEdge<G>& edge : a.edges()) {
    const G T_a = a.nodes()[edge.i].pose.Between(a.nodes()[edge.j].pose);
    const G T_b = b.nodes()[edge.i].pose.Between(b.nodes()[edge.j].pose);
    const double difference = T_a.LocalCoordinates(T_b).norm();
    if (!(difference <= largest)) largest = difference;  // a NaN stays
  }
  return largest;
}

}  // namespace hpgo
