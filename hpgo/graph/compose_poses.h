// Poses of nodes that have none, composed along the edges.
#pragma once

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// Gives every node without a pose one: breadth first from the nodes that have one, along odometry
// (edge_classes.h) as far as it leads, then along one loop closure, and so on. Where no node of a
// component has a pose, its first in id order gets the identity. Poses that are there stay as they
// are. Returns the number of poses composed.
template <typename G>
int ComposeMissingPoses(PoseGraph<G>* graph);

}  // namespace hpgo
