#include "hpgo/report/graph_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "hpgo/report/axis_ticks.h"
#include "hpgo/report/panel.h"
#include "hpgo/report/plot_view.h"
#include "hpgo/report/svg.h"

namespace hpgo {
namespace {

constexpr double kMargin = 24;
constexpr double kGap = 32;
constexpr double kTitleHeight = 34;
constexpr double kLabelHeight = 44;
constexpr double kFooterHeight = 44;
// Height of the drawing area, as a share of its width.
constexpr double kMinAspect = 0.45, kMaxAspectOne = 0.7, kMaxAspectMany = 0.95;
// Panels share one scale if their extents differ by less than this.
constexpr double kSharedScaleRatio = 1.8;

std::string Count(std::size_t count, const std::string& noun) {
  std::string digits = std::to_string(count);
  for (int place = static_cast<int>(digits.size()) - 3; place > 0; place -= 3) {
    digits.insert(place, ",");
  }
  return digits + " " + noun + (count == 1 ? "" : "s");
}

std::string Facts(const PlotGraph& graph) {
  std::string text = Count(graph.positions.size(), "node") + ", " + Count(graph.num_edges, "edge") +
                     ", " + Count(graph.closures.size(), "loop closure");
  if (graph.chi2.has_value()) {
    char number[48];
    const double size = std::abs(*graph.chi2);
    const char* format = size >= 1e7 ? ", chi2 %.4e" : size >= 1000 ? ", chi2 %.2f" : ", chi2 %.5g";
    std::snprintf(number, sizeof(number), format, *graph.chi2);
    text += number;
  }
  return text;
}

struct Layout {
  double panel_width = 0;
  double panel_height = 0;
  double top = 0;  // of the drawing areas
  double height = 0;
  std::vector<double> scales;  // pixels per metre, a panel each
};

Layout MakeLayout(const std::vector<PlotBox>& boxes, const GraphPlotOptions& options) {
  Layout layout;
  const double count = static_cast<double>(boxes.size());
  layout.panel_width = (options.width - 2 * kMargin - (count - 1) * kGap) / count;
  double aspect = kMinAspect;
  for (const PlotBox& box : boxes) aspect = std::max(aspect, box.size().y() / box.size().x());
  layout.panel_height =
      layout.panel_width * std::min(aspect, boxes.size() == 1 ? kMaxAspectOne : kMaxAspectMany);
  layout.top = kMargin + (options.title.empty() ? 0 : kTitleHeight) + kLabelHeight;
  layout.height = layout.top + layout.panel_height + kFooterHeight + kMargin;
  constexpr double kInset = 10;  // for line widths and marks
  for (const PlotBox& box : boxes) {
    layout.scales.push_back(std::min((layout.panel_width - kInset) / box.size().x(),
                                     (layout.panel_height - kInset) / box.size().y()));
  }
  const auto [low, high] = std::minmax_element(layout.scales.begin(), layout.scales.end());
  if (*high < kSharedScaleRatio * *low) {
    layout.scales.assign(layout.scales.size(), *low);
  }
  return layout;
}

// A bar of a round length with its length in metres, its right end at `right`.
std::string ScaleBar(const Eigen::Vector2d& right, double pixels_per_metre, double panel_width) {
  const double metres = RoundDown125(0.25 * panel_width / pixels_per_metre);
  const double length = metres * pixels_per_metre;
  SvgPath path;
  constexpr double kTick = 4;
  path.MoveTo(right + Eigen::Vector2d(-length, -kTick));
  path.LineTo(right + Eigen::Vector2d(-length, 0));
  path.LineTo(right);
  path.LineTo(right + Eigen::Vector2d(0, -kTick));
  char label[32];
  std::snprintf(label, sizeof(label), "%g m", metres);
  return "<path stroke=\"#4a5361\" stroke-width=\"1.2\" d=\"" + path.data() + "\"/>\n" +
         SvgText(right + Eigen::Vector2d(-length / 2, -7), "text-anchor=\"middle\"", label);
}

std::string Swatch(const Eigen::Vector2d& at, const char* color, double width) {
  return "<path stroke=\"" + std::string(color) + "\" stroke-width=\"" + SvgNumber(width) +
         "\" d=\"m" + SvgNumber(at.x()) + " " + SvgNumber(at.y()) + "h20\"/>\n";
}

std::string Legend(const std::vector<PlotGraph>& graphs, const GraphPlotOptions& options,
                   double y) {
  std::size_t closures = 0;
  int stride = 1;
  for (const PlotGraph& graph : graphs) {
    closures += graph.closures.size();
    stride = std::max(stride, ClosureStride(graph, options.max_closures));
  }
  const double baseline = y + 4.5;
  std::string svg = "<circle cx=\"" + SvgNumber(kMargin + 5) + "\" cy=\"" + SvgNumber(y) +
                    "\" r=\"4.5\" fill=\"" + kStartColor + "\"/>\n" +
                    SvgText({kMargin + 16, baseline}, "", "start") +
                    Swatch({kMargin + 64, y}, kTrajectoryColor, 2) +
                    SvgText({kMargin + 91, baseline}, "", "trajectory");
  if (closures > 0) {
    svg += Swatch({kMargin + 172, y}, kClosureColor, 2) +
           SvgText({kMargin + 199, baseline}, "",
                   stride == 1 ? "loop closure"
                               : "loop closure (1 in " + std::to_string(stride) + " drawn)");
  }
  return svg;
}

}  // namespace

Result<std::string> GraphPlotSvg(const std::vector<PlotGraph>& graphs,
                                 const GraphPlotOptions& options) {
  if (graphs.empty()) return Status(StatusCode::kInvalidArgument, "no graph to draw");
  constexpr int kMinWidth = 200;
  if (options.width < kMinWidth) {
    return Status(StatusCode::kInvalidArgument, "a picture of " + std::to_string(options.width) +
                                                    " pixels is too narrow; 200 is the least");
  }
  for (const PlotGraph& graph : graphs) {
    if (graph.positions.empty()) {
      return Status(StatusCode::kInvalidArgument,
                    "the graph '" + graph.label + "' has no nodes to draw");
    }
  }
  // The last graph is the one after optimization, of which the shape can be trusted.
  const PlotView view = PlotView::Of(graphs.back());
  std::vector<PlotBox> boxes;
  for (const PlotGraph& graph : graphs) boxes.push_back(ProjectedBox(graph, view));
  const Layout layout = MakeLayout(boxes, options);

  std::string body;
  if (!options.title.empty()) {
    body += SvgText({kMargin, kMargin + 14}, "class=\"title\"", options.title);
  }
  for (std::size_t k = 0; k < graphs.size(); ++k) {
    const double left = kMargin + static_cast<double>(k) * (layout.panel_width + kGap);
    body += SvgText({left, layout.top - 28}, "class=\"label\"", graphs[k].label) +
            SvgText({left, layout.top - 10}, "", Facts(graphs[k]));
    const Eigen::Vector2d center(left + layout.panel_width / 2,
                                 layout.top + layout.panel_height / 2);
    body += DrawPanel(graphs[k], view, boxes[k], center, {options.max_closures, layout.scales[k]});
    body += ScaleBar({left + layout.panel_width, layout.height - kMargin}, layout.scales[k],
                     layout.panel_width);
  }
  body += Legend(graphs, options, layout.height - kMargin - 4);
  return SvgDocument(options.width, layout.height, options.title, body);
}

}  // namespace hpgo
