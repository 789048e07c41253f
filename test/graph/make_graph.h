// Graphs by their topology alone.
#pragma once

#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// Nodes of the given ids, and edges between their indices.
template <typename G>
PoseGraph<G> MakeGraph(const std::vector<NodeId>& ids,
                       const std::vector<std::pair<int, int>>& edges) {
  PoseGraph<G> graph;
  for (const NodeId id : ids) {
    GraphNode<G> node;
    node.id = id;
    EXPECT_TRUE(graph.AddNode(node).ok());
  }
  for (const auto& [i, j] : edges) {
    GraphEdge<G> edge;
    edge.i = i;
    edge.j = j;
    EXPECT_TRUE(graph.AddEdge(edge).ok());
  }
  return graph;
}

using Groups = testing::Types<SE2, SE3>;

}  // namespace hpgo
