#include "hpgo/report/line_chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hpgo/report/axis_ticks.h"
#include "hpgo/report/polyline.h"
#include "hpgo/report/svg.h"

namespace hpgo {
namespace {

constexpr const char* kColors[] = {"#1d4f86", "#e0621f", "#1f8a4c",
                                   "#8e3a8c", "#c79a00", "#5b6673"};
constexpr const char* kGridColor = "#dedad0";
constexpr const char* kMinorGridColor = "#f0eee8";
constexpr const char* kAxisColor = "#8a919c";
constexpr double kTolerancePixels = 0.2;
constexpr double kCharWidth = 7;  // of the 13 pixel font, on the wide side

Status Check(const std::vector<ChartSeries>& series, const LineChartOptions& options) {
  std::size_t points = 0;
  for (const ChartSeries& one : series) {
    if (one.x.size() != one.y.size()) {
      return Status(StatusCode::kInvalidArgument,
                    "series '" + one.name + "' has " + std::to_string(one.x.size()) +
                        " x values and " + std::to_string(one.y.size()) + " y values");
    }
    for (std::size_t k = 0; k < one.x.size(); ++k) {
      const bool fits_x = std::isfinite(one.x[k]) && (!options.log_x || one.x[k] > 0);
      const bool fits_y = std::isfinite(one.y[k]) && (!options.log_y || one.y[k] > 0);
      if (!fits_x || !fits_y) {
        return Status(StatusCode::kInvalidArgument,
                      "point " + std::to_string(k) + " of series '" + one.name + "', (" +
                          std::to_string(one.x[k]) + ", " + std::to_string(one.y[k]) +
                          "), does not fit the axes");
      }
    }
    points += one.x.size();
  }
  if (points == 0) return Status(StatusCode::kInvalidArgument, "no points to draw");
  return Status::Ok();
}

// One axis: values to pixels.
class Axis {
 public:
  Axis(bool is_log, double low, double high) : is_log_(is_log), low_(low), high_(high) {
    if (is_log_) {
      if (high_ < 1.01 * low_) low_ /= 2, high_ *= 2;
    } else if (high_ - low_ < 1e-12 * std::max(1.0, std::abs(low_))) {
      low_ -= 0.5;
      high_ += 0.5;
    }
  }
  void SetPixels(double first, double last) {
    first_ = first;
    last_ = last;
  }
  double ToPixel(double value) const {
    const double t =
        is_log_ ? std::log(value / low_) / std::log(high_ / low_) : (value - low_) / (high_ - low_);
    return first_ + t * (last_ - first_);
  }
  std::vector<AxisTick> Ticks() const {
    const bool is_vertical = last_ < first_;  // labels are wider than high
    const double pixels_per_tick = is_vertical ? 50 : 70;
    const int count = std::max(2, static_cast<int>(std::abs(last_ - first_) / pixels_per_tick));
    return is_log_ ? LogTicks(low_, high_) : LinearTicks(low_, high_, count);
  }

 private:
  bool is_log_;
  double low_;
  double high_;
  double first_ = 0;
  double last_ = 1;
};

// Adds room: on a linear axis zero (if wanted) and 5 % above, on a logarithmic one 15 %.
Axis MakeAxis(const std::vector<ChartSeries>& series, std::vector<double> ChartSeries::*values,
              bool is_log, bool from_zero, double log_room) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const ChartSeries& one : series) {
    for (const double value : one.*values) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (is_log) return Axis(true, low / log_room, high * log_room);
  if (from_zero && low >= 0) low = 0;
  return Axis(false, low, from_zero ? high + 0.05 * (high - low) : high);
}

std::string Line(double x1, double y1, double x2, double y2, const char* color) {
  SvgPath path;
  path.Segment({x1, y1}, {x2, y2});
  return "<path stroke=\"" + std::string(color) + "\" d=\"" + path.data() + "\"/>\n";
}

const char* GridColor(const AxisTick& tick) {
  return tick.label.empty() ? kMinorGridColor : kGridColor;
}

struct Frame {
  double left, right, top, bottom;
};

std::string DrawAxes(const Frame& frame, const Axis& x, const Axis& y,
                     const LineChartOptions& options) {
  std::string svg;
  for (const AxisTick& tick : x.Ticks()) {
    const double at = x.ToPixel(tick.value);
    svg += Line(at, frame.top, at, frame.bottom, GridColor(tick));
    if (tick.label.empty()) continue;
    svg += SvgText({at, frame.bottom + 18}, "text-anchor=\"middle\"", tick.label);
  }
  for (const AxisTick& tick : y.Ticks()) {
    const double at = y.ToPixel(tick.value);
    svg += Line(frame.left, at, frame.right, at, GridColor(tick));
    if (tick.label.empty()) continue;
    svg += SvgText({frame.left - 8, at + 4.5}, "text-anchor=\"end\"", tick.label);
  }
  svg += Line(frame.left, frame.bottom, frame.right, frame.bottom, kAxisColor) +
         Line(frame.left, frame.top, frame.left, frame.bottom, kAxisColor) +
         SvgText({(frame.left + frame.right) / 2, frame.bottom + 40}, "text-anchor=\"middle\"",
                 options.x_label);
  // Turned about the point where it stands.
  const double middle = (frame.top + frame.bottom) / 2;
  return svg +
         SvgText({18, middle},
                 "text-anchor=\"middle\" transform=\"rotate(-90 18 " + SvgNumber(middle) + ")\"",
                 options.y_label);
}

std::string DrawSeries(const ChartSeries& series, const char* color, const Axis& x, const Axis& y) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t k = 0; k < series.x.size(); ++k) {
    points.emplace_back(x.ToPixel(series.x[k]), y.ToPixel(series.y[k]));
  }
  SvgPath path;
  for (const int k : SimplifyPolyline(points, kTolerancePixels)) {
    k == 0 ? path.MoveTo(points[k]) : path.LineTo(points[k]);
  }
  std::string svg;
  if (!path.empty()) {
    svg += "<path stroke=\"" + std::string(color) + "\" stroke-width=\"2\"" +
           (series.dashed ? " stroke-dasharray=\"6 5\"" : "") + " d=\"" + path.data() + "\"/>\n";
  }
  if (series.markers) {
    for (const Eigen::Vector2d& point : points) {
      svg += "<circle cx=\"" + SvgNumber(point.x()) + "\" cy=\"" + SvgNumber(point.y()) +
             "\" r=\"3.4\" fill=\"" + color + "\" stroke=\"#fbfaf7\"/>\n";
    }
  }
  return svg;
}

// The legend in rows from (left, top); returns the height it takes.
double DrawLegend(const std::vector<ChartSeries>& series, double left, double right, double top,
                  std::string* svg) {
  constexpr double kRow = 22, kSwatch = 24, kGap = 22;
  double x = left, y = top;
  for (std::size_t k = 0; k < series.size(); ++k) {
    const double width = kSwatch + 6 + kCharWidth * static_cast<double>(series[k].name.size());
    if (x > left && x + width > right) {
      x = left;
      y += kRow;
    }
    const char* color = kColors[k % std::size(kColors)];
    *svg += "<path stroke=\"" + std::string(color) + "\" stroke-width=\"2.4\"" +
            (series[k].dashed ? " stroke-dasharray=\"6 5\"" : "") + " d=\"m" + SvgNumber(x) + " " +
            SvgNumber(y) + "h" + SvgNumber(kSwatch) + "\"/>\n" +
            SvgText({x + kSwatch + 6, y + 4.5}, "", series[k].name);
    x += width + kGap;
  }
  return y - top + kRow;
}

double LongestLabel(const Axis& axis) {
  std::size_t longest = 0;
  for (const AxisTick& tick : axis.Ticks()) longest = std::max(longest, tick.label.size());
  return kCharWidth * static_cast<double>(longest);
}

}  // namespace

Result<std::string> LineChartSvg(const std::vector<ChartSeries>& series,
                                 const LineChartOptions& options) {
  const Status status = Check(series, options);
  if (!status.ok()) return status;
  Axis x = MakeAxis(series, &ChartSeries::x, options.log_x, /*from_zero=*/false, 1.0);
  Axis y = MakeAxis(series, &ChartSeries::y, options.log_y, /*from_zero=*/true, 1.15);

  constexpr double kMargin = 24;
  std::string body;
  Frame frame = {0, options.width - kMargin, kMargin, options.height - 62.0};
  if (!options.title.empty()) {
    body += SvgText({kMargin, kMargin + 10}, "class=\"title\"", options.title);
    frame.top += 34;
  }
  frame.top += DrawLegend(series, kMargin + 4, frame.right, frame.top, &body);
  y.SetPixels(frame.bottom, frame.top);
  frame.left = 42 + LongestLabel(y);
  x.SetPixels(frame.left, frame.right);
  body += DrawAxes(frame, x, y, options);
  for (std::size_t k = 0; k < series.size(); ++k) {
    body += DrawSeries(series[k], kColors[k % std::size(kColors)], x, y);
  }
  return SvgDocument(options.width, options.height, options.title, body);
}

}  // namespace hpgo
