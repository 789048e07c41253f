// Hierarchies over plain graphs, for the tests and benchmarks of windows.
#pragma once

#include <algorithm>
#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

// The graph's nodes in their order, each grouped when its edges to older nodes are there, as in a
// replay; all coarse edges merged. Priors are not taken over.
template <typename G>
Hierarchy<G> MakeHierarchy(const PoseGraph<G>& graph, const HierarchyOptions& options) {
  Hierarchy<G> hierarchy(options);
  std::vector<std::vector<int>> edges(graph.nodes().size());  // by the newer end
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    const GraphEdge<G>& edge = graph.edges()[k];
    edges[std::max(edge.i, edge.j)].push_back(static_cast<int>(k));
  }
  for (std::size_t n = 0; n < edges.size(); ++n) {
    const GraphNode<G>& node = graph.nodes()[n];
    const Index index = hierarchy.AddNode(node.pose);
    for (const int k : edges[n]) {
      const GraphEdge<G>& edge = graph.edges()[k];
      EdgeData<G> data;
      data.term = {edge.measurement, ceres_costs::PackedSymmetric<G::kDof>(edge.information)};
      data.weight = ModularityWeight(data.term);
      hierarchy.AddEdge(edge.i, edge.j, data);
    }
    if (node.fixed) hierarchy.SetFixed(index, true);
    hierarchy.AssignGroups();
  }
  for (int l = 1; l < hierarchy.num_levels(); ++l) {
    Level<G>& level = hierarchy.mutable_level(l);
    for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
      if (level.edges[e].alive) hierarchy.Merge(l, e);
      level.edges[e].dirty = false;
    }
    level.dirty.clear();
  }
  return hierarchy;
}

}  // namespace hpgo
