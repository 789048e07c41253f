// A chart of curves over one variable, as SVG: latency against the number of nodes, and the like.
#pragma once

#include <string>
#include <vector>

#include "hpgo/graph/status.h"

namespace hpgo {

struct ChartSeries {
  std::string name;  // in the legend
  std::vector<double> x;
  std::vector<double> y;  // as many as x
  bool dashed = false;
  bool markers = false;  // a dot at every point
};

struct LineChartOptions {
  std::string title;  // empty: none
  std::string x_label;
  std::string y_label;
  bool log_x = false;
  bool log_y = false;
  // A linear y axis starts at zero unless a value is negative.
  int width = 760;  // pixels
  int height = 460;
};

// Series are drawn in the order given, in a fixed order of colours that differ in lightness too;
// from the seventh on the colours repeat. kInvalidArgument, naming the series and the point, for a
// value that is not finite or not positive on a logarithmic axis, for x and y of different length,
// and where there is no point at all.
Result<std::string> LineChartSvg(const std::vector<ChartSeries>& series,
                                 const LineChartOptions& options);

}  // namespace hpgo
