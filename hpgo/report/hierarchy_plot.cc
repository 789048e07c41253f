#include "hpgo/report/hierarchy_plot.h"

#include <algorithm>
#include <cstdio>

#include "hpgo/report/group_panel.h"
#include "hpgo/report/panel.h"
#include "hpgo/report/plot_view.h"
#include "hpgo/report/svg.h"

namespace hpgo {
namespace {

constexpr double kMargin = 24;
constexpr double kGap = 28;
constexpr double kTitleHeight = 30;
constexpr double kCaptionHeight = 26;
constexpr double kLabelHeight = 40;
constexpr double kMinAspect = 0.5, kMaxAspect = 1.1;
constexpr double kInset = 10;  // for line widths and marks
constexpr int kMaxColumns = 3;
constexpr int kMaxClosures = 3000;
constexpr int kMinWidth = 200;

std::string Count(std::size_t count, const std::string& noun) {
  std::string digits = std::to_string(count);
  for (int place = static_cast<int>(digits.size()) - 3; place > 0; place -= 3) {
    digits.insert(place, ",");
  }
  return digits + " " + noun + (count == 1 ? "" : "s");
}

Status Check(const PlotGraph& graph, const std::vector<PlotHierarchyLevel>& levels,
             const HierarchyPlotOptions& options) {
  const auto invalid = [](const std::string& text) {
    return Status(StatusCode::kInvalidArgument, text);
  };
  if (graph.positions.empty()) {
    return invalid("the graph '" + graph.label + "' has no nodes to draw");
  }
  if (options.width < kMinWidth) {
    return invalid("a picture of " + std::to_string(options.width) +
                   " pixels is too narrow; 200 is the least");
  }
  for (const PlotHierarchyLevel& level : levels) {
    const auto is_group = [&level](int g) { return g >= 0 && g < level.num_groups; };
    const std::string name = "level " + std::to_string(level.level);
    if (level.group.size() != graph.positions.size()) {
      return invalid(name + " has groups for " + std::to_string(level.group.size()) + " of " +
                     std::to_string(graph.positions.size()) + " nodes");
    }
    for (const int group : level.group) {
      if (group != -1 && !is_group(group)) {
        return invalid(name + " has no group " + std::to_string(group));
      }
    }
    for (const auto& [a, b] : level.edges) {
      if (!is_group(a) || !is_group(b))
        return invalid(name + " has an edge between unknown groups");
    }
  }
  return Status::Ok();
}

// Levels that can be seen, and what is to be said about the others.
std::vector<const PlotHierarchyLevel*> Visible(const std::vector<PlotHierarchyLevel>& levels,
                                               int max_groups, std::string* caption) {
  std::vector<const PlotHierarchyLevel*> visible;
  int hidden = 0;
  for (const PlotHierarchyLevel& level : levels) {
    level.num_groups <= max_groups ? visible.push_back(&level) : static_cast<void>(++hidden);
  }
  *caption = "One colour a group; grey: the edges between groups";
  if (hidden > 0) *caption += ". Too fine to be seen: " + Count(hidden, "level");
  return visible;
}

std::string Facts(const PlotHierarchyLevel& level, std::size_t nodes) {
  char share[32];
  std::snprintf(share, sizeof(share), " (%.3g %%), ",
                100.0 * level.num_groups / static_cast<double>(nodes));
  return Count(level.num_groups, "group") + share + Count(level.edges.size(), "edge");
}

}  // namespace

Result<std::string> HierarchyPlotSvg(const PlotGraph& graph,
                                     const std::vector<PlotHierarchyLevel>& levels,
                                     const HierarchyPlotOptions& options) {
  const Status status = Check(graph, levels, options);
  if (!status.ok()) return status;
  std::string caption;
  const std::vector<const PlotHierarchyLevel*> visible =
      Visible(levels, options.max_groups, &caption);

  const PlotView view = PlotView::Of(graph);
  const PlotBox box = ProjectedBox(graph, view);
  const int panels = 1 + static_cast<int>(visible.size());
  const int columns = panels == 4 ? 2 : std::min(kMaxColumns, panels);
  const int rows = (panels + columns - 1) / columns;
  const double width = (options.width - 2 * kMargin - (columns - 1) * kGap) / columns;
  const double height = width * std::clamp(box.size().y() / box.size().x(), kMinAspect, kMaxAspect);
  const double scale =
      std::min((width - kInset) / box.size().x(), (height - kInset) / box.size().y());

  double top = kMargin;
  std::string body;
  if (!options.title.empty()) {
    body += SvgText({kMargin, top + 14}, "class=\"title\"", options.title);
    top += kTitleHeight;
  }
  body += SvgText({kMargin, top + 10}, "", caption);
  top += kCaptionHeight;
  for (int k = 0; k < panels; ++k) {
    const double left = kMargin + (k % columns) * (width + kGap);
    const double y = top + (k / columns) * (kLabelHeight + height + kGap);
    const Eigen::Vector2d center(left + width / 2, y + kLabelHeight + height / 2);
    std::string name = "level 0: the graph", facts;
    if (k == 0) {
      facts = Count(graph.positions.size(), "node") + ", " + Count(graph.num_edges, "edge");
      body += DrawPanel(graph, view, box, center, {kMaxClosures, scale});
    } else {
      const PlotHierarchyLevel& level = *visible[k - 1];
      name = "level " + std::to_string(level.level);
      facts = Facts(level, graph.positions.size());
      body += DrawGroupPanel(graph, level, view, box, center, scale);
    }
    body += SvgText({left, y + 12}, "class=\"label\"", name) + SvgText({left, y + 30}, "", facts);
  }
  const double total = top + rows * (kLabelHeight + height + kGap) - kGap + kMargin;
  return SvgDocument(options.width, total, options.title, body);
}

}  // namespace hpgo
