#include "hpgo/graph/edge_classes.h"

#include <limits>

#include "gmock/gmock.h"
#include "test/graph/make_graph.h"

namespace hpgo {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

template <typename G>
class EdgeClassesTest : public testing::Test {};
TYPED_TEST_SUITE(EdgeClassesTest, Groups);

TYPED_TEST(EdgeClassesTest, OfAnEmptyGraph) {
  EXPECT_THAT(LoopClosures(PoseGraph<TypeParam>()), IsEmpty());
  EXPECT_THAT(IdOrder(PoseGraph<TypeParam>()), IsEmpty());
}

TYPED_TEST(EdgeClassesTest, NodesInTheOrderOfTheirIds) {
  const NodeId huge = std::numeric_limits<NodeId>::max();
  const NodeId tiny = std::numeric_limits<NodeId>::min();
  EXPECT_THAT(IdOrder(MakeGraph<TypeParam>({huge, 5, tiny, -1}, {})), ElementsAre(2, 3, 1, 0));
}

TYPED_TEST(EdgeClassesTest, OdometryLinksNeighboursInIdOrder) {
  // Ids 10, 20, 30 with gaps and out of order; directions of both kinds.
  const auto graph = MakeGraph<TypeParam>({30, 10, 20}, {{1, 2}, {0, 2}, {0, 1}});
  EXPECT_THAT(LoopClosures(graph), ElementsAre(false, false, true));
}

TYPED_TEST(EdgeClassesTest, ASecondEdgeBetweenNeighboursIsAClosure) {
  const auto graph = MakeGraph<TypeParam>({0, 1, 2}, {{0, 1}, {1, 0}, {1, 2}, {0, 1}});
  EXPECT_THAT(LoopClosures(graph), ElementsAre(false, true, false, true));
}

TYPED_TEST(EdgeClassesTest, FirstAndLastAreNotNeighbours) {
  const auto graph = MakeGraph<TypeParam>({0, 1, 2, 3}, {{3, 0}, {0, 1}, {2, 3}});
  EXPECT_THAT(LoopClosures(graph), ElementsAre(true, false, false));
}

}  // namespace
}  // namespace hpgo
