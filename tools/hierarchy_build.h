// The hierarchy over a recorded graph, grown node by node, and what can be said about it.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/report/hierarchy_plot.h"

namespace hpgo_cli {

template <typename G>
struct BuiltHierarchy {
  std::unique_ptr<hpgo::Hierarchy<G>> hierarchy;
  std::vector<hpgo::Index> index;  // on level 0, of each node of the graph
  // Microseconds to insert each node: with its edges, and up to its groups on all levels.
  std::vector<float> insert_us;
  std::int64_t coarse_edges = 0;
  double coarse_seconds = 0;  // to compute all of them
};

// Every node must have a pose.
template <typename G>
BuiltHierarchy<G> BuildIncrementally(const hpgo::PoseGraph<G>& graph,
                                     const hpgo::HierarchyOptions& options);

struct LevelFigures {
  std::int64_t nodes = 0, edges = 0;
  double fraction = 1;   // of the nodes of level 0
  double reduction = 0;  // nodes of the level below over those of this one; 0 on level 0
  // How many groups have 1, 2, ... members on this level; empty on the top.
  std::vector<std::int64_t> group_sizes;
  double modularity = 0;  // Q of these groups (paper, eq. 1)
};

template <typename G>
std::vector<LevelFigures> FiguresOf(const hpgo::Hierarchy<G>& hierarchy);

template <typename G>
std::vector<hpgo::PlotHierarchyLevel> PlotLevels(const BuiltHierarchy<G>& built);

}  // namespace hpgo_cli
