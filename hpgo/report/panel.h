// One graph drawn into a rectangle of a picture.
#pragma once

#include <string>

#include "Eigen/Core"
#include "hpgo/report/plot_view.h"

namespace hpgo {

struct PanelStyle {
  int max_closures = 0;
  double pixels_per_metre = 1;
};

extern const char* const kTrajectoryColor;
extern const char* const kClosureColor;
extern const char* const kStartColor;

// The SVG of the graph, seen through `view`, with the middle of `content` (metres, as projected) at
// the pixel `center`.
std::string DrawPanel(const PlotGraph& graph, const PlotView& view, const PlotBox& content,
                      const Eigen::Vector2d& center, const PanelStyle& style);

// Every n-th loop closure is drawn.
int ClosureStride(const PlotGraph& graph, int max_closures);

}  // namespace hpgo
