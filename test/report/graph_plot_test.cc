#include "hpgo/report/graph_plot.h"

#include <cmath>
#include <regex>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A ring of `count` nodes of the given radius, every node with a closure to the one opposite.
PlotGraph Ring(int count, double radius, bool is_3d) {
  PlotGraph graph;
  graph.label = "ring";
  graph.is_3d = is_3d;
  graph.runs.emplace_back();
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * M_PI * k / count;
    graph.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle),
                                 is_3d ? 0.1 * k : 0);
    graph.runs[0].push_back(k);
    graph.closures.emplace_back(k, (k + count / 2) % count);
  }
  graph.num_edges = 2 * count - 1;
  return graph;
}

std::string Plot(const std::vector<PlotGraph>& graphs, const GraphPlotOptions& options = {}) {
  const Result<std::string> svg = GraphPlotSvg(graphs, options);
  EXPECT_TRUE(svg.ok()) << svg.status().ToString();
  return svg.ok() ? *svg : "";
}

int CountOf(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

// Every tag that is opened is closed, in order.
void ExpectBalanced(const std::string& svg) {
  static const std::regex kTag("<(/?)([a-z]+)[^>]*?(/?)>");
  std::vector<std::string> open;
  for (std::sregex_iterator it(svg.begin(), svg.end(), kTag), end; it != end; ++it) {
    const std::smatch& tag = *it;
    if (tag[3] == "/") continue;
    if (tag[1] == "/") {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), tag[2]);
      open.pop_back();
    } else {
      open.push_back(tag[2]);
    }
  }
  EXPECT_TRUE(open.empty());
}

TEST(GraphPlotTest, StatesTheCounts) {
  PlotGraph ring = Ring(1200, 10, false);
  EXPECT_THAT(Plot({ring}), HasSubstr(">1,200 nodes, 2,399 edges, 1,200 loop closures</text>"));
  ring.chi2 = 14574.752;
  EXPECT_THAT(Plot({ring}), HasSubstr("1,200 loop closures, chi2 14574.75</text>"));
  ring.chi2 = 1.23869;
  EXPECT_THAT(Plot({ring}), HasSubstr("1,200 loop closures, chi2 1.2387</text>"));
}

TEST(GraphPlotTest, IsWellFormed) {
  GraphPlotOptions options;
  options.title = "a <b> & \"c\"";
  PlotGraph ring = Ring(100, 10, true);
  ring.label = "x<y.g2o";
  const std::string svg = Plot({ring, Ring(50, 10, true)}, options);
  ExpectBalanced(svg);
  EXPECT_THAT(svg, HasSubstr("a &lt;b&gt; &amp; &quot;c&quot;</text>"));
  EXPECT_THAT(svg, HasSubstr("x&lt;y.g2o"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(GraphPlotTest, APictureIsRepeatable) {
  const std::vector<PlotGraph> graphs = {Ring(100, 10, true), Ring(100, 12, true)};
  EXPECT_EQ(Plot(graphs), Plot(graphs));
}

TEST(GraphPlotTest, ThreeDimensionsAreShadedByDepth) {
  // Six shades of the trajectory and six of the closures, against one of each.
  const int shaded = CountOf(Plot({Ring(1000, 10, true)}), "<path stroke=\"#");
  const int flat = CountOf(Plot({Ring(1000, 10, false)}), "<path stroke=\"#");
  EXPECT_GE(shaded, flat + 6);
}

TEST(GraphPlotTest, ThinsOutClosuresAndSaysSo) {
  GraphPlotOptions options;
  options.max_closures = 100;
  const std::string thinned = Plot({Ring(1000, 10, false)}, options);
  EXPECT_THAT(thinned, HasSubstr("loop closure (1 in 10 drawn)"));
  const std::string whole = Plot({Ring(1000, 10, false)});
  EXPECT_THAT(whole, HasSubstr(">loop closure</text>"));
  EXPECT_LT(thinned.size(), whole.size());
}

TEST(GraphPlotTest, ALargeGraphStaysCompact) {
  PlotGraph walk = Ring(200000, 10, false);
  for (std::size_t k = 0; k < walk.positions.size(); ++k) {
    walk.positions[k] += 0.05 * Eigen::Vector3d(std::sin(13.7 * static_cast<double>(k)),
                                                std::cos(7.9 * static_cast<double>(k)), 0);
  }
  EXPECT_LT(Plot({walk}).size(), 1500000u);
}

TEST(GraphPlotTest, TheScaleBarIsTrue) {
  // A square of 100 m: the bar's length and the square's side have one scale.
  PlotGraph square;
  square.positions = {{0, 0, 0}, {100, 0, 0}, {100, 100, 0}, {0, 100, 0}};
  square.runs = {{0, 1, 2, 3}};
  square.num_edges = 3;
  const std::string svg = Plot({square});
  std::smatch bar, path;
  ASSERT_TRUE(std::regex_search(
      svg, bar,
      std::regex("d=\"m[0-9.]+ [0-9.]+l0 4 ([0-9.]+) 0 0-4\"/>\n<text[^>]*>([0-9]+) m<")));
  ASSERT_TRUE(
      std::regex_search(svg, path, std::regex("d=\"m[0-9.]+ [0-9.]+l([0-9.]+) 0 0-([0-9.]+)-")));
  const double side = std::stod(path[1]);
  EXPECT_DOUBLE_EQ(side, std::stod(path[2])) << "equal axes";
  EXPECT_NEAR(std::stod(bar[1]) / std::stod(bar[2]), side / 100, 0.01);
}

TEST(GraphPlotTest, OneNodeIsDrawn) {
  PlotGraph graph;
  graph.label = "one";
  graph.positions = {{5, 5, 0}};
  graph.runs = {{0}};
  const std::string svg = Plot({graph});
  EXPECT_THAT(svg, HasSubstr(">1 node, 0 edges, 0 loop closures</text>"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(GraphPlotTest, RejectsWhatCannotBeDrawn) {
  EXPECT_EQ(GraphPlotSvg({}, {}).status().message(), "no graph to draw");
  PlotGraph empty;
  empty.label = "a.g2o";
  EXPECT_EQ(GraphPlotSvg({empty}, {}).status().message(), "the graph 'a.g2o' has no nodes to draw");
  GraphPlotOptions narrow;
  narrow.width = 20;
  EXPECT_EQ(GraphPlotSvg({Ring(10, 1, false)}, narrow).status().message(),
            "a picture of 20 pixels is too narrow; 200 is the least");
}

}  // namespace
}  // namespace hpgo
