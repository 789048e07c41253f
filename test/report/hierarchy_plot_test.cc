#include "hpgo/report/hierarchy_plot.h"

#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/report/group_panel.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

// A straight line of nodes a metre apart, in groups of `size` that follow one another.
PlotGraph Line(int count) {
  PlotGraph graph;
  graph.label = "line";
  graph.num_edges = count - 1;
  graph.runs.emplace_back();
  for (int k = 0; k < count; ++k) {
    graph.positions.emplace_back(k, 0, 0);
    graph.runs[0].push_back(k);
  }
  return graph;
}
PlotHierarchyLevel Groups(int count, int size, int level) {
  PlotHierarchyLevel groups;
  groups.level = level;
  groups.num_groups = (count + size - 1) / size;
  for (int k = 0; k < count; ++k) groups.group.push_back(k / size);
  for (int g = 0; g + 1 < groups.num_groups; ++g) groups.edges.emplace_back(g, g + 1);
  return groups;
}

int CountOf(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) {
    ++count;
  }
  return count;
}

std::string ErrorOf(const PlotGraph& graph, const PlotHierarchyLevel& level, int width = 960) {
  HierarchyPlotOptions options;
  options.width = width;
  const Result<std::string> svg = HierarchyPlotSvg(graph, {level}, options);
  return svg.ok() ? "" : svg.status().message();
}

TEST(ColorGroupsTest, NeighboursDiffer) {
  // A wheel: the hub touches every group of the rim.
  PlotHierarchyLevel level;
  level.num_groups = 41;
  for (int g = 1; g <= 40; ++g) {
    level.edges.emplace_back(0, g);
    level.edges.emplace_back(g, g % 40 + 1);
  }
  const std::vector<int> colors = ColorGroups(level, 5);
  ASSERT_EQ(colors.size(), 41u);
  for (const auto& [a, b] : level.edges) EXPECT_NE(colors[a], colors[b]) << a << " " << b;
  EXPECT_EQ(std::set<int>(colors.begin(), colors.end()).size(), 5u);  // all are used
}

TEST(HierarchyPlotTest, DrawsAPanelForEachLevel) {
  const Result<std::string> svg =
      HierarchyPlotSvg(Line(90), {Groups(90, 3, 1), Groups(90, 9, 2)}, {"A <line>", 960, 4000});
  ASSERT_TRUE(svg.ok()) << svg.status().ToString();
  EXPECT_THAT(*svg, HasSubstr("A &lt;line&gt;"));
  EXPECT_THAT(*svg, HasSubstr(">level 0: the graph<"));
  EXPECT_THAT(*svg, HasSubstr(">90 nodes, 89 edges<"));
  EXPECT_THAT(*svg, HasSubstr(">level 1<"));
  EXPECT_THAT(*svg, HasSubstr(">30 groups (33.3 %), 29 edges<"));
  EXPECT_THAT(*svg, HasSubstr(">10 groups (11.1 %), 9 edges<"));
  EXPECT_THAT(*svg, Not(HasSubstr("Too fine")));
  // A dot a group, besides one for each node of the graph and its start.
  EXPECT_EQ(CountOf(*svg, "<circle"), 30 + 10 + 90 + 1);
  EXPECT_THAT(*svg, Not(HasSubstr("nan")));
}

TEST(HierarchyPlotTest, LeavesOutLevelsTooFineToSee) {
  HierarchyPlotOptions options;
  options.max_groups = 20;
  const Result<std::string> svg =
      HierarchyPlotSvg(Line(90), {Groups(90, 3, 1), Groups(90, 9, 2)}, options);
  ASSERT_TRUE(svg.ok()) << svg.status().ToString();
  EXPECT_THAT(*svg, HasSubstr("Too fine to be seen: 1 level<"));
  EXPECT_THAT(*svg, Not(HasSubstr(">level 1<")));
  EXPECT_THAT(*svg, HasSubstr(">level 2<"));
}

TEST(HierarchyPlotTest, StaysSmall) {
  PlotGraph graph = Line(60000);
  graph.is_3d = true;
  for (int k = 0; k < 60000; ++k) graph.positions[k].y() = 500 * std::sin(0.01 * k);
  std::vector<PlotHierarchyLevel> levels;
  for (int size = 3, l = 1; size < 60000; size *= 3, ++l) levels.push_back(Groups(60000, size, l));
  const Result<std::string> svg = HierarchyPlotSvg(graph, levels, {});
  ASSERT_TRUE(svg.ok()) << svg.status().ToString();
  EXPECT_LT(svg->size(), 600000u);
}

TEST(HierarchyPlotTest, RejectsWhatDoesNotFit) {
  PlotHierarchyLevel level = Groups(9, 3, 2);
  EXPECT_EQ(ErrorOf(Line(9), level), "");
  EXPECT_EQ(ErrorOf(Line(8), level), "level 2 has groups for 9 of 8 nodes");
  EXPECT_EQ(ErrorOf(PlotGraph(), level), "the graph '' has no nodes to draw");
  EXPECT_EQ(ErrorOf(Line(9), level, 199),
            "a picture of 199 pixels is too narrow; 200 is the least");
  level.group[4] = 3;
  EXPECT_EQ(ErrorOf(Line(9), level), "level 2 has no group 3");
  level.group[4] = -1;  // in no group: left out
  EXPECT_EQ(ErrorOf(Line(9), level), "");
  level.edges.emplace_back(0, 3);
  EXPECT_EQ(ErrorOf(Line(9), level), "level 2 has an edge between unknown groups");
}

}  // namespace
}  // namespace hpgo
