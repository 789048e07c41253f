// A recorded graph fed to an Optimizer as it might have arrived: nodes in the order of their ids,
// each with its edges to earlier ones.
#pragma once

#include <functional>
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

// The pose of a node of an earlier step, by its index in the graph.
template <typename G>
using PoseOfNode = std::function<Result<G>(int)>;

// Where a step's node starts: at an earlier neighbour's pose composed with the edge between them,
// at its prior where it has no such neighbour, else at its own pose in the graph. A fixed node is
// always there. Errors are those of `pose_of`.
template <typename G>
Result<G> StartPose(const PoseGraph<G>& graph, const ReplayStep& step,
                    const PoseOfNode<G>& pose_of);

// Adds a step's node at `pose`, its edges and priors. Does not update.
template <typename G>
Status AddStep(const PoseGraph<G>& graph, const ReplayStep& step, const G& pose,
               const typename Optimizer<G>::Loss& closure_loss, Optimizer<G>* optimizer);

// AddStep at the StartPose in the optimizer's current estimate.
template <typename G>
Status ApplyStep(const PoseGraph<G>& graph, const ReplayStep& step,
                 const typename Optimizer<G>::Loss& closure_loss, Optimizer<G>* optimizer);

}  // namespace hpgo
