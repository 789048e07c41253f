// Every call that is refused says why and changes nothing.

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "ceres/sized_cost_function.h"
#include "gtest/gtest.h"
#include "hpgo/optimizer.h"

namespace hpgo {
namespace {

template <typename G>
class ErrorsTest : public testing::Test {
 protected:
  using Information = typename G::Matrix;

  ErrorsTest() {
    EXPECT_TRUE(optimizer_.AddNode(7, G()).ok());
    EXPECT_TRUE(optimizer_.AddNode(-3, Step()).ok());
    edge_ = *optimizer_.AddEdge(7, -3, Step(), Information::Identity());
    prior_ = *optimizer_.AddPrior(7, G(), Information::Identity());
    optimizer_.Update();
  }
  // Nothing of the constructor's graph has changed.
  ~ErrorsTest() override {
    EXPECT_EQ(optimizer_.num_nodes(), 2u);
    EXPECT_EQ(optimizer_.num_edges(), 2u);
    EXPECT_LT(optimizer_.Cost(), 1e-20);
    EXPECT_EQ(optimizer_.FindInconsistency(), "");
  }

  static G Step() {
    G step;
    step.translation()(0) = 1;
    return step;
  }
  static G BadPose() {
    G pose;
    pose.translation()(1) = std::nan("");
    return pose;
  }
  static void ExpectError(const Status& status, StatusCode code, const std::string& message) {
    EXPECT_EQ(status.code(), code) << status.ToString();
    EXPECT_EQ(status.message(), message);
  }

  Optimizer<G> optimizer_;
  EdgeId edge_, prior_;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(ErrorsTest, Groups);

constexpr StatusCode kInvalid = StatusCode::kInvalidArgument;
constexpr StatusCode kMissing = StatusCode::kNotFound;

TYPED_TEST(ErrorsTest, Nodes) {
  auto& optimizer = this->optimizer_;
  this->ExpectError(optimizer.AddNode(7, TypeParam()), StatusCode::kAlreadyExists, "node 7 exists");
  this->ExpectError(optimizer.AddNode(8, this->BadPose()), kInvalid,
                    "node 8: the pose is not finite");
  this->ExpectError(optimizer.SetPose(-3, this->BadPose()), kInvalid,
                    "node -3: the pose is not finite");
  this->ExpectError(optimizer.SetPose(9, TypeParam()), kMissing, "no node 9");
  this->ExpectError(optimizer.SetFixed(9, true), kMissing, "no node 9");
  this->ExpectError(optimizer.RemoveNode(9).status(), kMissing, "no node 9");
  this->ExpectError(optimizer.GetPose(9).status(), kMissing, "no node 9");
  this->ExpectError(optimizer.MarginalCovariance(9).status(), kMissing, "no node 9");
  this->ExpectError(optimizer.GetGroup(9, 0).status(), kMissing, "no node 9");
  this->ExpectError(optimizer.GetGroup(7, 1).status(), kInvalid, "no level 1");
  this->ExpectError(optimizer.GetGroup(7, -1).status(), kInvalid, "no level -1");
  EXPECT_FALSE(optimizer.HasNode(9));
  EXPECT_TRUE(optimizer.HasNode(-3));
}

TYPED_TEST(ErrorsTest, Edges) {
  using Matrix = typename TypeParam::Matrix;
  auto& optimizer = this->optimizer_;
  const TypeParam Z = this->Step();
  const Matrix I = Matrix::Identity();
  this->ExpectError(optimizer.AddEdge(7, 9, Z, I).status(), kMissing, "edge 7 -> 9: no node 9");
  this->ExpectError(optimizer.AddEdge(9, 7, Z, I).status(), kMissing, "edge 9 -> 7: no node 9");
  this->ExpectError(optimizer.AddEdge(7, 7, Z, I).status(), kInvalid, "edge 7 -> 7: a self edge");
  this->ExpectError(optimizer.AddEdge(7, -3, this->BadPose(), I).status(), kInvalid,
                    "edge 7 -> -3: the measurement is not finite");
  Matrix bad = I;
  bad(0, 0) = -1;
  const std::string indefinite =
      ": information is not positive semi-definite, smallest eigenvalue -1";
  this->ExpectError(optimizer.AddEdge(7, -3, Z, bad).status(), kInvalid,
                    "edge 7 -> -3" + indefinite);
  this->ExpectError(optimizer.AddPrior(7, Z, bad).status(), kInvalid,
                    "prior of node 7" + indefinite);
  this->ExpectError(optimizer.UpdateEdge(this->edge_, Z, bad), kInvalid,
                    "edge 7 -> -3" + indefinite);
  this->ExpectError(optimizer.UpdateEdge(this->prior_, Z, bad), kInvalid,
                    "prior of node 7" + indefinite);
  bad = I;
  bad(1, 0) = 0.5;  // the half that no file stores
  this->ExpectError(optimizer.AddEdge(7, -3, Z, bad).status(), kInvalid,
                    "edge 7 -> -3: information is not symmetric");
  bad(1, 0) = std::numeric_limits<double>::infinity();
  this->ExpectError(optimizer.AddEdge(7, -3, Z, bad).status(), kInvalid,
                    "edge 7 -> -3: information is not finite");
  this->ExpectError(optimizer.AddPrior(9, Z, I).status(), kMissing, "prior of node 9: no node 9");
  this->ExpectError(optimizer.AddPrior(7, Z, I, this->BadPose()).status(), kInvalid,
                    "prior of node 7: the offset is not finite");
  this->ExpectError(optimizer.UpdateEdge(this->edge_, this->BadPose(), I), kInvalid,
                    "edge 7 -> -3: the measurement is not finite");
}

TEST(ErrorsTest3d, AZeroQuaternionIsNoPose) {
  const double zeros[7] = {};
  Optimizer3d optimizer;
  const Status status = optimizer.AddNode(1, SE3(zeros));
  EXPECT_EQ(status.code(), kInvalid);
  EXPECT_EQ(status.message(), "node 1: the pose has a zero quaternion");
}

TYPED_TEST(ErrorsTest, IdsOfRemovedEdgesAreStale) {
  using Matrix = typename TypeParam::Matrix;
  auto& optimizer = this->optimizer_;
  const EdgeId old = *optimizer.AddEdge(-3, 7, this->Step(), Matrix::Identity());
  ASSERT_TRUE(optimizer.RemoveEdge(old).ok());
  // Its place is used again, its name is not.
  const EdgeId fresh = *optimizer.AddEdge(-3, 7, this->Step(), Matrix::Identity());
  EXPECT_NE(old, fresh);
  const std::string message = "no edge with the id " + std::to_string(old.value);
  this->ExpectError(optimizer.RemoveEdge(old), kMissing, message);
  this->ExpectError(optimizer.UpdateEdge(old, TypeParam(), Matrix::Identity()), kMissing, message);
  this->ExpectError(optimizer.GetEdgeError(old).status(), kMissing, message);
  this->ExpectError(optimizer.RemoveEdge(EdgeId()), kMissing, "no edge with the id -1");
  this->ExpectError(optimizer.RemoveEdge(EdgeId{12345}), kMissing, "no edge with the id 12345");
  ASSERT_TRUE(optimizer.RemoveEdge(fresh).ok());
}

TYPED_TEST(ErrorsTest, AddGraphAddsAllOrNothing) {
  auto& optimizer = this->optimizer_;
  PoseGraph<TypeParam> graph;
  for (const NodeId id : {20, 21, 22}) {
    GraphNode<TypeParam> node;
    node.id = id;
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  GraphEdge<TypeParam> edge;
  edge.j = 1;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  GraphPrior<TypeParam> prior;
  prior.node = 2;
  ASSERT_TRUE(graph.AddPrior(prior).ok());

  graph.prior(0).information(0, 0) = -1;
  const Status status = optimizer.AddGraph(graph);
  EXPECT_EQ(status.code(), kInvalid);
  EXPECT_EQ(status.message().find("prior of node 22: "), 0u) << status.message();
  graph.prior(0).offset = this->BadPose();
  graph.prior(0).information(0, 0) = 1;
  this->ExpectError(optimizer.AddGraph(graph), kInvalid,
                    "prior of node 22: the offset is not finite");
  graph.edge(0).information(0, 1) = 0.1;
  this->ExpectError(optimizer.AddGraph(graph), kInvalid,
                    "edge 20 -> 21: information is not symmetric");
  graph.node(2).pose = this->BadPose();
  this->ExpectError(optimizer.AddGraph(graph), kInvalid, "node 22: the pose is not finite");
  GraphNode<TypeParam> taken;
  taken.id = -3;
  PoseGraph<TypeParam> clash;
  ASSERT_TRUE(clash.AddNode(graph.nodes()[0]).ok());
  ASSERT_TRUE(clash.AddNode(taken).ok());
  this->ExpectError(optimizer.AddGraph(clash), StatusCode::kAlreadyExists, "node -3 exists");
  EXPECT_FALSE(optimizer.HasNode(20));
}

TYPED_TEST(ErrorsTest, OptionsOutOfRange) {
  OptimizerOptions options;
  options.max_group_size = 1;
  EXPECT_EQ(options.Validate().code(), kInvalid);
  EXPECT_NE(options.Validate().message().find("max_group_size"), std::string::npos);
  options = {};
  options.stress_threshold = std::nan("");
  EXPECT_EQ(options.Validate().code(), kInvalid);
  EXPECT_TRUE(OptimizerOptions::Paper().Validate().ok());
  this->ExpectError(OptimizerOptions::FromName("slow").status(), kInvalid,
                    "no preset 'slow': accurate, fast, eager or paper");
}

TYPED_TEST(ErrorsTest, ClearStartsAnew) {
  Optimizer<TypeParam> optimizer(OptimizerOptions::Fast());
  ASSERT_TRUE(optimizer.AddNode(1, TypeParam()).ok());
  optimizer.Update();
  optimizer.Clear();
  EXPECT_EQ(optimizer.num_nodes(), 0u);
  EXPECT_EQ(optimizer.options().window_nodes, OptimizerOptions::Fast().window_nodes);
  ASSERT_TRUE(optimizer.AddNode(1, this->Step()).ok());
  EXPECT_EQ(optimizer.Update().new_nodes, 1);
  EXPECT_EQ(optimizer.GetPose(1)->data()[0], 1);
}

}  // namespace
}  // namespace hpgo
