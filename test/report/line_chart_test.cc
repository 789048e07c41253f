#include "hpgo/report/line_chart.h"

#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

ChartSeries Series(const std::string& name, std::vector<double> x, std::vector<double> y) {
  ChartSeries series;
  series.name = name;
  series.x = std::move(x);
  series.y = std::move(y);
  return series;
}

TEST(LineChartTest, HasTitleLabelsLegendAndTicks) {
  LineChartOptions options;
  options.title = "Latency & more";
  options.x_label = "nodes";
  options.y_label = "milliseconds";
  options.log_x = options.log_y = true;
  const Result<std::string> svg = LineChartSvg(
      {Series("p50", {1e3, 1e4, 1e6}, {1, 2, 1}), Series("p99", {1e3}, {100})}, options);
  ASSERT_TRUE(svg.ok()) << svg.status().ToString();
  for (const char* text : {"Latency &amp; more", ">nodes<", ">milliseconds<", ">p50<", ">p99<",
                           ">1k<", ">10k<", ">100k<", ">1M<", ">1<", ">10<", ">100<"}) {
    EXPECT_THAT(*svg, HasSubstr(text));
  }
}

TEST(LineChartTest, ALinearAxisStartsAtZero) {
  const Result<std::string> svg = LineChartSvg({Series("a", {0, 1, 2}, {50, 60, 70})}, {});
  ASSERT_TRUE(svg.ok());
  EXPECT_THAT(*svg, HasSubstr("text-anchor=\"end\">0<"));
}

TEST(LineChartTest, DrawsMarkersAndDashes) {
  ChartSeries series = Series("a", {1, 2}, {3, 4});
  EXPECT_THAT(*LineChartSvg({series}, {}), Not(HasSubstr("<circle")));
  series.markers = series.dashed = true;
  const Result<std::string> svg = LineChartSvg({series}, {});
  EXPECT_THAT(*svg, HasSubstr("<circle"));
  EXPECT_THAT(*svg, HasSubstr("stroke-dasharray"));
}

TEST(LineChartTest, OnePointIsFinite) {
  for (const bool is_log : {false, true}) {
    LineChartOptions options;
    options.log_x = options.log_y = is_log;
    const Result<std::string> svg = LineChartSvg({Series("a", {7}, {7})}, options);
    ASSERT_TRUE(svg.ok());
    EXPECT_THAT(*svg, Not(HasSubstr("nan")));
    EXPECT_THAT(*svg, Not(HasSubstr("-9223372036854775808")));
  }
}

TEST(LineChartTest, NamesThePointThatDoesNotFit) {
  LineChartOptions log_y;
  log_y.log_y = true;
  EXPECT_EQ(LineChartSvg({Series("p50", {1, 2}, {1, 0})}, log_y).status().message(),
            "point 1 of series 'p50', (2.000000, 0.000000), does not fit the axes");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(LineChartSvg({Series("p50", {1}, {nan})}, {}).status().message(),
            "point 0 of series 'p50', (1.000000, nan), does not fit the axes");
  EXPECT_EQ(LineChartSvg({Series("p50", {1, 2}, {1})}, {}).status().message(),
            "series 'p50' has 2 x values and 1 y values");
  EXPECT_EQ(LineChartSvg({Series("p50", {}, {})}, {}).status().message(), "no points to draw");
}

}  // namespace
}  // namespace hpgo
