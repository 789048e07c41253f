#include "hpgo/graph/compose_poses.h"

#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

// A graph whose nodes have no poses, and edges of length one along x unless said otherwise.
template <typename G>
struct Builder {
  PoseGraph<G> graph;

  void Node(NodeId id) {
    GraphNode<G> node;
    node.id = id;
    node.has_pose = false;
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  void Edge(NodeId i, NodeId j, double x = 1, double y = 0) {
    GraphEdge<G> edge;
    edge.i = *graph.Find(i);
    edge.j = *graph.Find(j);
    edge.measurement.translation()(0) = x;
    edge.measurement.translation()(1) = y;
    ASSERT_TRUE(graph.AddEdge(edge).ok());
  }
  double X(NodeId id) const { return graph.nodes()[*graph.Find(id)].pose.data()[0]; }
};

template <typename G>
class ComposePosesTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(ComposePosesTest, Groups);

TYPED_TEST(ComposePosesTest, PrefersOdometryToClosures) {
  Builder<TypeParam> b;
  for (NodeId id : {3, 1, 0, 2}) b.Node(id);
  b.Edge(0, 3, 100);  // a closure, listed first
  b.Edge(0, 1);
  b.Edge(2, 1, -1);  // backwards
  b.Edge(2, 3);
  EXPECT_EQ(ComposeMissingPoses(&b.graph), 4);
  for (NodeId id = 0; id < 4; ++id) EXPECT_DOUBLE_EQ(b.X(id), static_cast<double>(id));
}

TYPED_TEST(ComposePosesTest, GoesAlongAClosureWhereOdometryEnds) {
  Builder<TypeParam> b;
  for (NodeId id : {0, 1, 2, 3, 4}) b.Node(id);
  b.Edge(0, 1);
  b.Edge(1, 3, 5);
  b.Edge(3, 2, -1);
  b.Edge(3, 4);
  b.Edge(0, 4, 70);
  EXPECT_EQ(ComposeMissingPoses(&b.graph), 5);
  EXPECT_DOUBLE_EQ(b.X(1), 1);
  EXPECT_DOUBLE_EQ(b.X(4), 70);  // the first closure that was met
  EXPECT_DOUBLE_EQ(b.X(3), 69);
  EXPECT_DOUBLE_EQ(b.X(2), 68);
}

TYPED_TEST(ComposePosesTest, FillsOnlyWhatIsMissing) {
  Builder<TypeParam> b;
  for (NodeId id : {0, 1, 2}) b.Node(id);
  b.Edge(0, 1);
  b.Edge(1, 2);
  b.graph.node(1).has_pose = true;
  b.graph.node(1).pose.translation()(0) = 10;
  EXPECT_EQ(ComposeMissingPoses(&b.graph), 2);
  EXPECT_DOUBLE_EQ(b.X(0), 9);
  EXPECT_DOUBLE_EQ(b.X(1), 10);
  EXPECT_DOUBLE_EQ(b.X(2), 11);
  EXPECT_EQ(ComposeMissingPoses(&b.graph), 0);
}

TYPED_TEST(ComposePosesTest, EachComponentBeginsAtItsFirstNodeInIdOrder) {
  Builder<TypeParam> b;
  for (NodeId id : {8, 7, 1, 2}) b.Node(id);
  b.Edge(7, 8);
  b.Edge(2, 1);
  EXPECT_EQ(ComposeMissingPoses(&b.graph), 4);
  EXPECT_DOUBLE_EQ(b.X(7), 0);
  EXPECT_DOUBLE_EQ(b.X(8), 1);
  EXPECT_DOUBLE_EQ(b.X(1), 0);
  EXPECT_DOUBLE_EQ(b.X(2), -1);
}

TEST(ComposePoses, RotatesAndStaysUnitLength) {
  PoseGraph<SE3> graph;
  for (int k = 0; k < 2001; ++k) {
    GraphNode<SE3> node;
    node.id = k;
    node.has_pose = false;
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  const double step = 2 * std::acos(-1.0) / 1000;  // two full turns
  for (int k = 0; k < 2000; ++k) {
    GraphEdge<SE3> edge;
    edge.i = k;
    edge.j = k + 1;
    edge.measurement =
        SE3(Eigen::Vector3d(1, 0, 0), ceres_costs::So3Exp(Eigen::Vector3d(0, 0, step)));
    ASSERT_TRUE(graph.AddEdge(edge).ok());
  }
  EXPECT_EQ(ComposeMissingPoses(&graph), 2001);
  EXPECT_NEAR(graph.nodes()[2000].pose.translation().norm(), 0, 1e-9);
  EXPECT_NEAR(graph.nodes()[2000].pose.rotation().norm(), 1, 1e-15);
  EXPECT_NEAR(graph.nodes()[500].pose.translation().norm(), 1 / std::sin(step / 2), 1e-9);
}

}  // namespace
}  // namespace hpgo
