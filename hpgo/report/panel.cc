#include "hpgo/report/panel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "hpgo/report/polyline.h"
#include "hpgo/report/svg.h"

namespace hpgo {

const char* const kTrajectoryColor = "#1d4f86";
const char* const kClosureColor = "#e0621f";
const char* const kStartColor = "#1f8a4c";

namespace {

using Color = std::array<int, 3>;
constexpr Color kTrajectoryNear = {20, 58, 104}, kTrajectoryFar = {158, 186, 216};
constexpr Color kClosureNear = {208, 78, 18}, kClosureFar = {246, 196, 160};
constexpr Color kTrajectoryFlat = {29, 79, 134}, kClosureFlat = {224, 98, 31};

constexpr int kDepthBins = 6;
// The trajectory is simplified until it has at most this many points.
constexpr std::size_t kMaxPoints = 60000;
constexpr double kTolerancePixels = 0.2;
// Up to this many nodes, each is marked.
constexpr std::size_t kMaxMarkedNodes = 300;
// Closures shorter than this (KITTI: the same street again) hide under the trajectory unless they
// are drawn wider than it.
constexpr double kShortClosurePixels = 5;

std::string Hex(const Color& near, const Color& far, double t) {
  char text[8];
  std::array<int, 3> mixed;
  for (int c = 0; c < 3; ++c) {
    mixed[c] = static_cast<int>(std::lround(near[c] + t * (far[c] - near[c]))) & 0xff;
  }
  std::snprintf(text, sizeof(text), "#%02x%02x%02x", mixed[0], mixed[1], mixed[2]);
  return text;
}

class PanelDrawing {
 public:
  PanelDrawing(const PlotGraph& graph, const PlotView& view, const PlotBox& content,
               const Eigen::Vector2d& center, const PanelStyle& style)
      : graph_(graph), style_(style), bins_(graph.is_3d ? kDepthBins : 1) {
    for (const Eigen::Vector3d& position : graph.positions) {
      const Eigen::Vector2d offset =
          style.pixels_per_metre * (view.Project(position) - content.center());
      pixels_.emplace_back(center.x() + offset.x(), center.y() - offset.y());
      depths_.push_back(view.Depth(position));
    }
    const auto [near, far] = std::minmax_element(depths_.begin(), depths_.end());
    nearest_ = *near;
    depth_range_ = std::max(*far - *near, 1e-9);
  }

  std::string Draw() {
    CollectTrajectory();
    CollectClosures();
    std::string svg;
    for (int bin = bins_ - 1; bin >= 0; --bin) {  // far to near
      svg += PathElement(closures_[bin], Shade(kClosureNear, kClosureFar, kClosureFlat, bin),
                         closure_width_, closure_opacity_);
      svg += PathElement(trajectory_[bin],
                         Shade(kTrajectoryNear, kTrajectoryFar, kTrajectoryFlat, bin),
                         TrajectoryWidth(), 1);
    }
    return svg + Marks();
  }

 private:
  int Bin(int a, int b) const {
    const double depth = (0.5 * (depths_[a] + depths_[b]) - nearest_) / depth_range_;
    return std::clamp(static_cast<int>(depth * bins_), 0, bins_ - 1);
  }

  std::string Shade(const Color& near, const Color& far, const Color& flat, int bin) const {
    if (bins_ == 1) return Hex(flat, flat, 0);
    return Hex(near, far, static_cast<double>(bin) / (bins_ - 1));
  }

  double TrajectoryWidth() const {
    const std::size_t count = graph_.positions.size();
    return count < 500 ? 1.8 : count < 20000 ? 1.3 : 0.9;
  }

  static std::string PathElement(const SvgPath& path, const std::string& color, double width,
                                 double opacity) {
    if (path.empty()) return "";
    char text[96];
    std::snprintf(text, sizeof(text), "<path stroke=\"%s\" stroke-width=\"%.3g\"", color.c_str(),
                  width);
    std::string element = text;
    if (opacity < 1) {
      std::snprintf(text, sizeof(text), " stroke-opacity=\"%.2g\"", opacity);
      element += text;
    }
    return element + " d=\"" + path.data() + "\"/>\n";
  }

  // The kept points of every run, as node indices.
  std::vector<std::vector<int>> SimplifiedRuns(double tolerance) const {
    std::vector<std::vector<int>> runs;
    for (const std::vector<int>& run : graph_.runs) {
      std::vector<Eigen::Vector2d> points;
      points.reserve(run.size());
      for (const int node : run) points.push_back(pixels_[node]);
      runs.emplace_back();
      for (const int k : SimplifyPolyline(points, tolerance)) runs.back().push_back(run[k]);
    }
    return runs;
  }

  void CollectTrajectory() {
    std::vector<std::vector<int>> runs;
    std::size_t count = 0;
    double tolerance = kTolerancePixels;
    do {
      runs = SimplifiedRuns(tolerance);
      count = 0;
      for (const std::vector<int>& run : runs) count += run.size();
      tolerance *= 2;
      // Runs of one point each do not get fewer by a larger tolerance.
    } while (count > kMaxPoints && tolerance < 4);
    for (const std::vector<int>& run : runs) {
      int last_bin = -1;
      for (std::size_t k = 0; k + 1 < run.size(); ++k) {
        const int bin = Bin(run[k], run[k + 1]);
        if (bin != last_bin) trajectory_[bin].MoveTo(pixels_[run[k]]);
        trajectory_[bin].LineTo(pixels_[run[k + 1]]);
        last_bin = bin;
      }
      if (run.size() == 1) {
        trajectory_[Bin(run[0], run[0])].Segment(pixels_[run[0]], pixels_[run[0]]);
      }
    }
  }

  void CollectClosures() {
    const int stride = ClosureStride(graph_, style_.max_closures);
    std::vector<double> lengths;
    for (std::size_t k = 0; k < graph_.closures.size(); k += stride) {
      const auto [i, j] = graph_.closures[k];
      closures_[Bin(i, j)].Segment(pixels_[i], pixels_[j]);
      lengths.push_back((pixels_[i] - pixels_[j]).norm());
    }
    if (lengths.empty()) return;
    const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
    std::nth_element(lengths.begin(), middle, lengths.end());
    if (*middle < kShortClosurePixels) {
      closure_width_ = TrajectoryWidth() + 3.2;
      closure_opacity_ = 0.7;
    } else {
      closure_width_ = lengths.size() < 500 ? 1.2 : lengths.size() < 3000 ? 0.8 : 0.5;
      closure_opacity_ = lengths.size() < 500 ? 0.9 : 0.6;
    }
  }

  std::string Circle(const Eigen::Vector2d& at, const std::string& attributes) const {
    return "<circle cx=\"" + SvgNumber(at.x()) + "\" cy=\"" + SvgNumber(at.y()) + "\" " +
           attributes + "/>\n";
  }

  std::string Marks() const {
    std::string svg;
    if (pixels_.size() <= kMaxMarkedNodes) {
      for (const Eigen::Vector2d& pixel : pixels_) {
        svg += Circle(pixel, "r=\"2.4\" fill=\"" + std::string(kTrajectoryColor) + "\"");
      }
    }
    if (!graph_.runs.empty()) {
      svg += Circle(pixels_[graph_.runs[0][0]], "r=\"4.5\" fill=\"" + std::string(kStartColor) +
                                                    "\" stroke=\"#fff\" stroke-width=\"1.5\"");
    }
    return svg;
  }

  const PlotGraph& graph_;
  const PanelStyle& style_;
  const int bins_;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<double> depths_;
  double nearest_ = 0;
  double depth_range_ = 1;
  std::array<SvgPath, kDepthBins> trajectory_;
  std::array<SvgPath, kDepthBins> closures_;
  double closure_width_ = 1;
  double closure_opacity_ = 1;
};

}  // namespace

int ClosureStride(const PlotGraph& graph, int max_closures) {
  const int count = static_cast<int>(graph.closures.size());
  return max_closures > 0 ? std::max(1, (count + max_closures - 1) / max_closures) : 1;
}

std::string DrawPanel(const PlotGraph& graph, const PlotView& view, const PlotBox& content,
                      const Eigen::Vector2d& center, const PanelStyle& style) {
  return PanelDrawing(graph, view, content, center, style).Draw();
}

}  // namespace hpgo
