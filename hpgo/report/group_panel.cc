#include "hpgo/report/group_panel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "hpgo/report/polyline.h"
#include "hpgo/report/svg.h"

namespace hpgo {
namespace {

using Color = std::array<int, 3>;
constexpr Color kPalette[] = {{29, 79, 134},  {224, 98, 31},  {31, 138, 76},  {142, 58, 140},
                              {214, 162, 0},  {200, 40, 60},  {38, 150, 170}, {120, 92, 60},
                              {92, 110, 210}, {110, 150, 30}, {230, 110, 150}};
constexpr int kColors = static_cast<int>(std::size(kPalette));
constexpr Color kBackground = {251, 250, 247};
constexpr const char* kEdgeColor = "#c9c6bd";

constexpr int kDepthBins = 4;
constexpr double kFade = 0.6;  // of the farthest bin towards the background
constexpr double kTolerancePixels = 0.3;
// With more groups than this, dots would cover each other.
constexpr int kMaxDots = 260;
constexpr int kMaxDrawnEdges = 4000;

std::string Faded(const Color& color, double share) {
  Color mixed;
  for (int c = 0; c < 3; ++c) {
    mixed[c] = static_cast<int>(std::lround(color[c] + share * (kBackground[c] - color[c]))) & 0xff;
  }
  char text[8];
  std::snprintf(text, sizeof(text), "#%02x%02x%02x", mixed[0], mixed[1], mixed[2]);
  return text;
}

class GroupDrawing {
 public:
  GroupDrawing(const PlotGraph& graph, const PlotHierarchyLevel& level, const PlotView& view,
               const PlotBox& content, const Eigen::Vector2d& center, double pixels_per_metre)
      : graph_(graph), level_(level), bins_(graph.is_3d ? kDepthBins : 1) {
    std::vector<double> depths;
    for (const Eigen::Vector3d& position : graph.positions) {
      const Eigen::Vector2d offset = pixels_per_metre * (view.Project(position) - content.center());
      pixels_.emplace_back(center.x() + offset.x(), center.y() - offset.y());
      depths.push_back(view.Depth(position));
    }
    const auto [near, far] = std::minmax_element(depths.begin(), depths.end());
    const double range = std::max(*far - *near, 1e-9);
    for (const double depth : depths) {
      const int bin = static_cast<int>((depth - *near) / range * bins_);
      bin_.push_back(std::clamp(bin, 0, bins_ - 1));
    }
    FindCenters();
    color_ = ColorGroups(level, kColors);
  }

  std::string Draw() {
    CollectStrokes();
    std::string svg = Edges();
    const double width = level_.num_groups <= kMaxDots ? 2.4 : 1.8;
    for (int bin = bins_ - 1; bin >= 0; --bin) {  // far to near
      for (int color = 0; color < kColors; ++color) {
        const SvgPath& path = strokes_[bin][color];
        if (path.empty()) continue;
        svg += "<path stroke=\"" + Shade(color, bin) + "\" stroke-width=\"" + SvgNumber(width) +
               "\" d=\"" + path.data() + "\"/>\n";
      }
      svg += Dots(bin);
    }
    return svg;
  }

 private:
  void FindCenters() {
    std::vector<int> count(level_.num_groups, 0);
    std::vector<double> bin_sum(level_.num_groups, 0);
    center_.assign(level_.num_groups, Eigen::Vector2d::Zero());
    for (std::size_t k = 0; k < pixels_.size(); ++k) {
      const int group = level_.group[k];
      if (group < 0) continue;
      center_[group] += pixels_[k];
      bin_sum[group] += bin_[k];
      ++count[group];
    }
    for (int g = 0; g < level_.num_groups; ++g) {
      const int divisor = std::max(1, count[g]);
      center_[g] /= divisor;
      center_bin_.push_back(static_cast<int>(std::lround(bin_sum[g] / divisor)));
      is_empty_.push_back(count[g] == 0);
    }
  }

  std::string Shade(int color, int bin) const {
    return Faded(kPalette[color], bins_ > 1 ? kFade * bin / (bins_ - 1) : 0);
  }

  // Draws a piece of the trajectory that belongs to one group.
  void AddStroke(const std::vector<int>& nodes) {
    const int color = color_[level_.group[nodes[0]]];
    SvgPath& path = strokes_[bin_[nodes[nodes.size() / 2]]][color];
    if (nodes.size() == 1) {
      path.Segment(pixels_[nodes[0]], pixels_[nodes[0]]);
      return;
    }
    std::vector<Eigen::Vector2d> points;
    for (const int node : nodes) points.push_back(pixels_[node]);
    for (const int k : SimplifyPolyline(points, kTolerancePixels)) {
      k == 0 ? path.MoveTo(points[k]) : path.LineTo(points[k]);
    }
  }

  void CollectStrokes() {
    std::vector<int> piece;
    for (const std::vector<int>& run : graph_.runs) {
      for (const int node : run) {
        const bool continues = !piece.empty() && level_.group[node] == level_.group[piece.back()] &&
                               bin_[node] == bin_[piece.back()];
        if (!continues && !piece.empty()) {
          AddStroke(piece);
          // Where only the depth changes, the stroke goes on from its last point.
          const bool same_group = level_.group[node] == level_.group[piece.back()];
          piece = same_group ? std::vector<int>{piece.back()} : std::vector<int>{};
        }
        if (level_.group[node] >= 0) piece.push_back(node);
      }
      if (!piece.empty()) AddStroke(piece);
      piece.clear();
    }
  }

  std::string Edges() const {
    SvgPath path;
    const int count = static_cast<int>(level_.edges.size());
    const int stride = 1 + count / kMaxDrawnEdges;
    for (int k = 0; k < count; k += stride) {
      path.Segment(center_[level_.edges[k].first], center_[level_.edges[k].second]);
    }
    if (path.empty()) return "";
    return "<path stroke=\"" + std::string(kEdgeColor) + "\" stroke-width=\"" +
           (count < 1000 ? "0.8" : "0.5") + "\" d=\"" + path.data() + "\"/>\n";
  }

  std::string Dots(int bin) const {
    if (level_.num_groups > kMaxDots) return "";
    const std::string radius = level_.num_groups <= kMaxDots / 2 ? "3.4" : "2.4";
    std::string svg;
    for (int g = 0; g < level_.num_groups; ++g) {
      if (center_bin_[g] != bin || is_empty_[g]) continue;
      svg += "<circle cx=\"" + SvgNumber(center_[g].x()) + "\" cy=\"" + SvgNumber(center_[g].y()) +
             "\" r=\"" + radius + "\" fill=\"" + Shade(color_[g], bin) +
             "\" stroke=\"#fbfaf7\"/>\n";
    }
    return svg;
  }

  const PlotGraph& graph_;
  const PlotHierarchyLevel& level_;
  const int bins_;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<int> bin_;  // of each node, 0 is nearest
  std::vector<Eigen::Vector2d> center_;
  std::vector<int> center_bin_;
  std::vector<bool> is_empty_;
  std::vector<int> color_;
  std::array<std::array<SvgPath, kColors>, kDepthBins> strokes_;
};

}  // namespace

std::vector<int> ColorGroups(const PlotHierarchyLevel& level, int count) {
  std::vector<std::vector<int>> neighbours(level.num_groups);
  for (const auto& [a, b] : level.edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  std::vector<int> color(level.num_groups, -1);
  std::vector<int> uses(count);
  for (int g = 0; g < level.num_groups; ++g) {
    std::fill(uses.begin(), uses.end(), 0);
    for (const int other : neighbours[g]) {
      if (color[other] >= 0) ++uses[color[other]];
    }
    // Begins at another colour for each group, so that all colours are used alike.
    int best = g % count;
    for (int k = 0; k < count; ++k) {
      const int candidate = (g + k) % count;
      if (uses[candidate] < uses[best]) best = candidate;
    }
    color[g] = best;
  }
  return color;
}

std::string DrawGroupPanel(const PlotGraph& graph, const PlotHierarchyLevel& level,
                           const PlotView& view, const PlotBox& content,
                           const Eigen::Vector2d& center, double pixels_per_metre) {
  return GroupDrawing(graph, level, view, content, center, pixels_per_metre).Draw();
}

}  // namespace hpgo
