// Initial guesses by composing measurements outwards from known poses.
#pragma once

#include <vector>

#include "hpgo/graph/components.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// A node whose pose an initial guess starts from.
template <typename G>
struct Anchor {
  int node = 0;
  G pose;             // T_world_node
  bool firm = false;  // a fixed node or a full prior; otherwise only the choice of a frame
};

// At least one anchor a component: its fixed nodes that have a pose; failing that, its first fixed
// node at the identity; failing that, the node of its first full-rank prior, at the pose the prior
// gives; failing that, its first node in id order, at its pose or the identity.
template <typename G>
std::vector<Anchor<G>> FindAnchors(const PoseGraph<G>& graph, const Components& components);

// Every node's pose, composed along the shortest paths from the anchors (Dijkstra), edge k being
// `lengths[k]` >= 0 long. Every component needs an anchor.
template <typename G>
std::vector<G> ComposeAlongShortestPaths(const PoseGraph<G>& graph,
                                         const std::vector<Anchor<G>>& anchors,
                                         const std::vector<double>& lengths);

// Lengths for which shortest paths follow the odometry (edge_classes.h) wherever it leads.
template <typename G>
std::vector<double> OdometryLengths(const PoseGraph<G>& graph);

// Lengths for which shortest paths accumulate the least uncertainty: det(covariance)^(1/dof), whose
// order does not depend on the units of length and angle.
template <typename G>
std::vector<double> UncertaintyLengths(const PoseGraph<G>& graph);

}  // namespace hpgo
