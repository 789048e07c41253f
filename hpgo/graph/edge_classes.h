// Which edges are odometry and which are loop closures.
#pragma once

#include <vector>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// For every edge, true if it is a loop closure: it does not connect two nodes that follow one
// another in id order, or an earlier edge already connects them.
template <typename G>
std::vector<bool> LoopClosures(const PoseGraph<G>& graph);

// Node indices in the order of their ids.
template <typename G>
std::vector<int> IdOrder(const PoseGraph<G>& graph);

}  // namespace hpgo
