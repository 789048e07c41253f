#include "hpgo/report/plot_graph.h"

#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

template <typename G>
PoseGraph<G> GraphOf(const std::vector<NodeId>& ids,
                     const std::vector<std::pair<int, int>>& edges) {
  PoseGraph<G> graph;
  for (const NodeId id : ids) {
    GraphNode<G> node;
    node.id = id;
    node.pose.translation()(0) = static_cast<double>(id);
    EXPECT_TRUE(graph.AddNode(node).ok());
  }
  for (const auto& [i, j] : edges) {
    GraphEdge<G> edge;
    edge.i = i;
    edge.j = j;
    EXPECT_TRUE(graph.AddEdge(edge).ok());
  }
  return graph;
}

TEST(MakePlotGraphTest, SplitsRunsWhereOdometryIsMissing) {
  // In id order: 1 3 | 5 7, with a closure from 1 to 7 and a second edge between 1 and 3.
  const auto graph = GraphOf<SE2>({7, 1, 5, 3}, {{1, 3}, {0, 2}, {1, 0}, {3, 1}});
  const Result<PlotGraph> plot = MakePlotGraph(graph, "name");
  ASSERT_TRUE(plot.ok()) << plot.status().ToString();
  EXPECT_THAT(plot->runs, ElementsAre(ElementsAre(1, 3), ElementsAre(2, 0)));
  EXPECT_THAT(plot->closures, ElementsAre(Pair(1, 0), Pair(3, 1)));
  EXPECT_EQ(plot->num_edges, 4);
  EXPECT_EQ(plot->label, "name");
  EXPECT_FALSE(plot->is_3d);
  EXPECT_EQ(plot->positions[0], Eigen::Vector3d(7, 0, 0));
}

TEST(MakePlotGraphTest, KnowsTheDimension) {
  const Result<PlotGraph> plot = MakePlotGraph(GraphOf<SE3>({0}, {}), "");
  ASSERT_TRUE(plot.ok());
  EXPECT_TRUE(plot->is_3d);
  EXPECT_THAT(plot->runs, ElementsAre(ElementsAre(0)));
}

TEST(MakePlotGraphTest, NamesANodeWithoutAPose) {
  auto graph = GraphOf<SE3>({4, 9}, {});
  graph.node(1).has_pose = false;
  const Result<PlotGraph> plot = MakePlotGraph(graph, "");
  ASSERT_FALSE(plot.ok());
  EXPECT_EQ(plot.status().code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(plot.status().message(), "node 9 has no finite pose to draw");
}

TEST(MakePlotGraphTest, NamesANodeThatIsNotFinite) {
  auto graph = GraphOf<SE2>({4, 9}, {});
  graph.node(0).pose.translation()(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(MakePlotGraph(graph, "").status().message(), "node 4 has no finite pose to draw");
}

}  // namespace
}  // namespace hpgo
