#include "hpgo/graph/pose_graph.h"

#include <limits>

#include "test/graph/make_graph.h"

namespace hpgo {
namespace {

template <typename G>
class PoseGraphTest : public testing::Test {};
TYPED_TEST_SUITE(PoseGraphTest, Groups);

TYPED_TEST(PoseGraphTest, FindsNodesByTheirIds) {
  const NodeId huge = std::numeric_limits<NodeId>::max();
  const auto graph = MakeGraph<TypeParam>({-4, huge, 17}, {});
  EXPECT_EQ(graph.nodes().size(), 3u);
  EXPECT_EQ(graph.Find(-4), std::optional<int>(0));
  EXPECT_EQ(graph.Find(huge), std::optional<int>(1));
  EXPECT_EQ(graph.Find(17), std::optional<int>(2));
  EXPECT_EQ(graph.Find(0), std::nullopt);
}

TYPED_TEST(PoseGraphTest, ANewNodeIsFreeAtTheIdentity) {
  const GraphNode<TypeParam> node;
  EXPECT_FALSE(node.fixed);
  EXPECT_TRUE(node.has_pose);
  EXPECT_EQ(node.pose.translation().norm(), 0);
  EXPECT_EQ(node.pose.matrix(), TypeParam::RotationMatrix::Identity());
}

TYPED_TEST(PoseGraphTest, ASecondNodeOfAnIdIsRefused) {
  auto graph = MakeGraph<TypeParam>({3}, {});
  GraphNode<TypeParam> node;
  node.id = 3;
  node.fixed = true;
  const Result<int> result = graph.AddNode(node);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kAlreadyExists);
  EXPECT_EQ(result.status().message(), "node 3 exists");
  EXPECT_EQ(graph.nodes().size(), 1u);
  EXPECT_FALSE(graph.nodes()[0].fixed);
  node.id = 4;
  EXPECT_EQ(graph.AddNode(node).value(), 1);
}

TYPED_TEST(PoseGraphTest, EdgesNeedTwoNodesOfTheGraph) {
  auto graph = MakeGraph<TypeParam>({10, 11}, {});
  GraphEdge<TypeParam> edge;
  for (const auto& [i, j] : {std::pair(0, 2), std::pair(-1, 0), std::pair(2, 0)}) {
    edge.i = i;
    edge.j = j;
    const Status status = graph.AddEdge(edge);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(status.message(), "edge between indices " + std::to_string(i) + " and " +
                                    std::to_string(j) + " of a graph of 2");
  }
  edge.i = edge.j = 1;
  const Status status = graph.AddEdge(edge);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), "self edge at node 11");
  EXPECT_TRUE(graph.edges().empty());
}

TYPED_TEST(PoseGraphTest, SeveralEdgesBetweenTheSameNodesAreKeptInOrder) {
  auto graph = MakeGraph<TypeParam>({10, 11}, {{0, 1}, {1, 0}, {0, 1}});
  ASSERT_EQ(graph.edges().size(), 3u);
  EXPECT_EQ(graph.edges()[1].i, 1);
  EXPECT_EQ(graph.edges()[1].information, TypeParam::Matrix::Identity());
  graph.edge(1).information *= 2;
  EXPECT_EQ(graph.edges()[1].information(0, 0), 2);
}

TYPED_TEST(PoseGraphTest, PriorsNeedANodeOfTheGraph) {
  auto graph = MakeGraph<TypeParam>({10}, {});
  GraphPrior<TypeParam> prior;
  ASSERT_TRUE(graph.AddPrior(prior).ok());
  for (const int node : {-1, 1}) {
    prior.node = node;
    const Status status = graph.AddPrior(prior);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(status.message(), "prior at index " + std::to_string(node) + " of a graph of 1");
  }
  EXPECT_EQ(graph.priors().size(), 1u);
}

TYPED_TEST(PoseGraphTest, CopiesAreIndependent) {
  const auto original = MakeGraph<TypeParam>({1, 2}, {{0, 1}});
  auto copy = original;
  copy.node(0).pose.translation()(0) = 5;
  GraphNode<TypeParam> node;
  node.id = 9;
  ASSERT_TRUE(copy.AddNode(node).ok());
  EXPECT_EQ(original.nodes()[0].pose.data()[0], 0);
  EXPECT_EQ(original.Find(9), std::nullopt);
  EXPECT_EQ(copy.Find(9), std::optional<int>(2));
}

TYPED_TEST(PoseGraphTest, ReserveChangesNothingThatIsSeen) {
  auto graph = MakeGraph<TypeParam>({1, 2}, {{0, 1}});
  graph.Reserve(1000, 5000);
  EXPECT_EQ(graph.nodes().size(), 2u);
  EXPECT_EQ(graph.edges().size(), 1u);
  EXPECT_EQ(graph.Find(2), std::optional<int>(1));
}

}  // namespace
}  // namespace hpgo
