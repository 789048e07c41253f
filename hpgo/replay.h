// A recorded graph fed to an Optimizer as it might have arrived: nodes in the order of their ids,
// each with its edges to earlier ones.
#pragma once

#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/optimizer.h"

namespace hpgo {

// One node with what arrives with it.
struct ReplayStep {
  int node = 0;            // index into the graph's nodes
  std::vector<int> edges;  // to earlier nodes; the one to the node just before it first
  int num_odometry = 0;    // the first of them, that are not loop closures: 0 or 1
  std::vector<int> priors;
  bool closes_loop() const { return static_cast<int>(edges.size()) > num_odometry; }
};

template <typename G>
std::vector<ReplayStep> ReplaySteps(const PoseGraph<G>& graph);

// Adds a step's node, edges and priors. The node starts at an earlier neighbour's current estimate
// composed with the edge between them, at its prior where it has no such neighbour, else at its own
// pose in the graph. Does not update.
template <typename G>
Status ApplyStep(const PoseGraph<G>& graph, const ReplayStep& step,
                 const typename Optimizer<G>::Loss& closure_loss, Optimizer<G>* optimizer);

}  // namespace hpgo
