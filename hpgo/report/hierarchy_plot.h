// A picture of the hierarchy over the trajectory, level by level, as SVG.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "hpgo/report/plot_graph.h"

namespace hpgo {

// One level above the graph itself: how its groups share the graph's nodes.
struct PlotHierarchyLevel {
  int level = 1;
  int num_groups = 0;
  std::vector<int> group;                  // of each node of the graph, from 0; -1: none
  std::vector<std::pair<int, int>> edges;  // between groups
};

struct HierarchyPlotOptions {
  std::string title;  // empty: none
  int width = 960;    // pixels
  // Levels with more groups than this are left out, as too fine to be seen; the caption says so.
  int max_groups = 4000;
};

// The trajectory first, then a panel for each level that is drawn: its pieces that belong to one
// group in one colour, neighbouring groups in different ones, the edges between groups in grey.
// Seen as GraphPlotSvg sees a graph. kInvalidArgument for a graph without nodes, a level with
// groups out of range, and a width below 200.
Result<std::string> HierarchyPlotSvg(const PlotGraph& graph,
                                     const std::vector<PlotHierarchyLevel>& levels,
                                     const HierarchyPlotOptions& options);

}  // namespace hpgo
