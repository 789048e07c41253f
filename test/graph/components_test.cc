#include "hpgo/graph/components.h"

#include "gmock/gmock.h"
#include "test/graph/make_graph.h"

namespace hpgo {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

template <typename G>
class ComponentsTest : public testing::Test {};
TYPED_TEST_SUITE(ComponentsTest, Groups);

TYPED_TEST(ComponentsTest, OfAnEmptyGraph) {
  const PoseGraph<TypeParam> graph;
  const Components components = FindComponents(graph);
  EXPECT_EQ(components.count, 0);
  EXPECT_THAT(components.of_node, IsEmpty());
  EXPECT_THAT(GaugeNodes(graph, components), IsEmpty());
}

TYPED_TEST(ComponentsTest, AreNumberedByTheirFirstNodes) {
  const auto graph =
      MakeGraph<TypeParam>({0, 1, 2, 3, 4, 5, 6}, {{5, 1}, {4, 2}, {2, 6}, {6, 4}, {1, 5}});
  const Components components = FindComponents(graph);
  EXPECT_EQ(components.count, 4);
  EXPECT_THAT(components.of_node, ElementsAre(0, 1, 2, 3, 2, 1, 2));
}

TYPED_TEST(ComponentsTest, OneEdgeJoinsTwo) {
  auto graph = MakeGraph<TypeParam>({0, 1, 2, 3}, {{0, 1}, {2, 3}});
  EXPECT_EQ(FindComponents(graph).count, 2);
  GraphEdge<TypeParam> edge;
  edge.i = 3;
  edge.j = 0;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  EXPECT_EQ(FindComponents(graph).count, 1);
}

TYPED_TEST(ComponentsTest, LongChainsInEitherDirection) {
  const int size = 100000;
  std::vector<NodeId> ids;
  std::vector<std::pair<int, int>> ahead, back;
  for (int k = 0; k < size; ++k) {
    ids.push_back(k);
    if (k == 0) continue;
    ahead.emplace_back(k - 1, k);
    back.emplace_back(size - k, size - k - 1);
  }
  EXPECT_EQ(FindComponents(MakeGraph<TypeParam>(ids, ahead)).count, 1);
  EXPECT_EQ(FindComponents(MakeGraph<TypeParam>(ids, back)).count, 1);
}

TYPED_TEST(ComponentsTest, GaugeIsTheSmallestIdOfEach) {
  const auto graph = MakeGraph<TypeParam>({7, -3, 5, 6}, {{0, 1}, {2, 3}});
  EXPECT_THAT(GaugeNodes(graph, FindComponents(graph)), ElementsAre(1, 2));
}

TYPED_TEST(ComponentsTest, FixedNodesAreTheGauge) {
  auto graph = MakeGraph<TypeParam>({0, 1, 2, 3, 4}, {{0, 1}, {1, 2}, {3, 4}});
  graph.node(1).fixed = true;
  graph.node(2).fixed = true;
  EXPECT_THAT(GaugeNodes(graph, FindComponents(graph)), ElementsAre(1, 2, 3));
}

TYPED_TEST(ComponentsTest, APriorHoldsItsComponent) {
  auto graph = MakeGraph<TypeParam>({0, 1, 2, 3}, {{0, 1}, {2, 3}});
  GraphPrior<TypeParam> prior;
  prior.node = 3;
  ASSERT_TRUE(graph.AddPrior(prior).ok());
  EXPECT_THAT(GaugeNodes(graph, FindComponents(graph)), ElementsAre(0));
  graph.node(3).fixed = true;
  EXPECT_THAT(GaugeNodes(graph, FindComponents(graph)), ElementsAre(3, 0));
}

}  // namespace
}  // namespace hpgo
