// What an update works with, for the tests of its parts.
#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "ceres/loss_function.h"
#include "hpgo/graph/pose_graph.h"
#include "hpgo/update/schedules.h"

namespace hpgo {

// A graph with its first node held, all of it taken in; nothing is pending, and no coarse edge is
// merged. `loss`: of the edges that close loops.
template <typename G>
class UpdateFixture {
 public:
  explicit UpdateFixture(const PoseGraph<G>& graph, const OptimizerOptions& options = {},
                         const std::shared_ptr<const ceres::LossFunction>& loss = nullptr)
      : options_(options),
        graph_({options.max_group_size, options.max_top_nodes, options.max_top_edges,
                options.coarse_edges, options.convention},
               options.condense_chains),
        step_(options.engine, &graph_.hierarchy(), [](Index e) { return std::to_string(e); }),
        sizes_(options) {
    for (const GraphNode<G>& node : graph.nodes()) graph_.AddNode(node.pose);
    graph_.SetHeld(0, true);
    for (const GraphEdge<G>& edge : graph.edges()) {
      EdgeData<G> data;
      data.term = {edge.measurement, ceres_costs::PackedSymmetric<G::kDof>(edge.information)};
      data.weight = ModularityWeight(data.term);
      if (edge.j != edge.i + 1) data.loss = loss;
      graph_.AddEdge(edge.i, edge.j, data);
    }
    graph_.Restructure();
    graph_.hierarchy().AssignGroups();
  }

  CondensedGraph<G>& graph() { return graph_; }
  Hierarchy<G>& hierarchy() { return graph_.hierarchy(); }
  UpdateTools<G> tools() { return {options_, graph_, step_, sizes_, sweep_}; }

 private:
  OptimizerOptions options_;
  CondensedGraph<G> graph_;
  WindowStep<G> step_;
  WindowSizes sizes_;
  Sweep sweep_;
};

// Whenever it is evaluated it costs so many times as much: there is no end to what it gains, or
// none to gain.
class EverOther : public ceres::LossFunction {
 public:
  EverOther(double factor, int* evaluations) : factor_(factor), evaluations_(evaluations) {}
  void Evaluate(double s, double rho[3]) const override {
    const double scale = std::pow(factor_, ++*evaluations_);
    rho[0] = scale * s;
    rho[1] = scale;
    rho[2] = 0;
  }

 private:
  const double factor_;
  int* evaluations_;
};

}  // namespace hpgo
