// A picture of one pose graph, or of two side by side, as SVG.
#pragma once

#include <string>
#include <vector>

#include "hpgo/report/plot_graph.h"

namespace hpgo {

struct GraphPlotOptions {
  std::string title;  // empty: none
  // Pixels. Affects the file's size: a trajectory is simplified to what this width can show.
  int width = 960;
  // More loop closures than this are thinned out evenly; the legend says so.
  int max_closures = 20000;
};

// One panel a graph, left to right, all seen from the same direction; at one scale unless their
// extents differ too much for that, each with its own scale bar. `graphs` is not empty and all have
// positions; otherwise kInvalidArgument.
Result<std::string> GraphPlotSvg(const std::vector<PlotGraph>& graphs,
                                 const GraphPlotOptions& options);

}  // namespace hpgo
