// One level of a hierarchy drawn into a rectangle of a picture.
#pragma once

#include <string>
#include <vector>

#include "Eigen/Core"
#include "hpgo/report/hierarchy_plot.h"
#include "hpgo/report/plot_view.h"

namespace hpgo {

// A small number for each group of a level, not that of any neighbour where `count` suffices.
std::vector<int> ColorGroups(const PlotHierarchyLevel& level, int count);

// As DrawPanel (panel.h), coloured by the groups of `level`.
std::string DrawGroupPanel(const PlotGraph& graph, const PlotHierarchyLevel& level,
                           const PlotView& view, const PlotBox& content,
                           const Eigen::Vector2d& center, double pixels_per_metre);

}  // namespace hpgo
