// What can be asked: errors of edges, groups, covariances, the graph itself.

#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "Eigen/Dense"
#include "ceres/loss_function.h"
#include "gtest/gtest.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class QueryTest : public testing::Test {
 protected:
  QueryTest() : known_(MakeKnownGraph<G>(30, 0.1, 3, 1000)), optimizer_(Options()) {
    EXPECT_TRUE(optimizer_.AddGraph(known_.graph).ok());
    optimizer_.Refine();
  }
  static OptimizerOptions Options() {
    OptimizerOptions options;
    options.max_top_nodes = 5;
    return options;
  }

  KnownGraph<G> known_;
  Optimizer<G> optimizer_;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(QueryTest, Groups);

TYPED_TEST(QueryTest, EdgeErrorsSumUpToTheCost) {
  const EdgeId prior = *this->optimizer_.AddPrior(1003, TypeParam(), TypeParam::Matrix::Identity());
  double sum = 0;
  for (const EdgeError& error : this->optimizer_.EdgeErrors()) {
    sum += error.chi2;
    EXPECT_EQ(this->optimizer_.GetEdgeError(error.id)->chi2, error.chi2);
    if (error.id == prior) {
      EXPECT_EQ(error.i, 1003);
      EXPECT_EQ(error.j, 1003);
      EXPECT_GT(error.chi2, 0);
    }
  }
  EXPECT_EQ(this->optimizer_.EdgeErrors().size(), this->optimizer_.num_edges());
  EXPECT_NEAR(sum, this->optimizer_.Cost(), 1e-9 * sum);
}

// What a robot that follows the map needs to know of an update.
TYPED_TEST(QueryTest, TheReportSaysHowFarPosesJump) {
  Optimizer<TypeParam> optimizer;
  TypeParam step;
  step.translation()(0) = 1;
  const typename TypeParam::Matrix I = TypeParam::Matrix::Identity();
  ASSERT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
  for (int k = 1; k <= 3; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, *optimizer.GetPose(k - 1) * step).ok());
    ASSERT_TRUE(optimizer.AddEdge(k - 1, k, step, I).ok());
    const UpdateReport report = optimizer.Update();
    EXPECT_EQ(report.newest_moved.distance, 0);
    EXPECT_EQ(report.largest_moved.distance, 0);
  }
  typename TypeParam::Tangent turn = TypeParam::Tangent::Zero();
  turn(TypeParam::kDof - 1) = 0.4;
  const TypeParam before = *optimizer.GetPose(3);
  ASSERT_TRUE(optimizer.AddEdge(0, 3, before.Retract(turn), 10 * I).ok());
  for (const UpdateReport& report : {optimizer.Update(), optimizer.Refine()}) {
    EXPECT_GE(report.largest_moved.distance, report.newest_moved.distance);
    EXPECT_GE(report.largest_moved.angle, report.newest_moved.angle);
  }
  const TypeParam moved_before = *optimizer.GetPose(3);
  ASSERT_TRUE(optimizer.AddEdge(0, 3, before, 30 * I).ok());
  const UpdateReport report = optimizer.Update();
  const typename TypeParam::Tangent moved = moved_before.LocalCoordinates(*optimizer.GetPose(3));
  EXPECT_GT(report.newest_moved.distance, 0.001);
  EXPECT_GT(report.newest_moved.angle, 0.01);
  EXPECT_NEAR(report.newest_moved.distance, moved.template head<TypeParam::kDim>().norm(), 1e-9);
  EXPECT_NEAR(report.newest_moved.angle, moved.template tail<TypeParam::kRotationDof>().norm(),
              1e-9);
}

TYPED_TEST(QueryTest, ErrorsAreWithoutTheLossAndTheCostWithIt) {
  Optimizer<TypeParam> optimizer;
  ASSERT_TRUE(optimizer.AddNode(1, TypeParam()).ok());
  ASSERT_TRUE(optimizer.AddNode(2, TypeParam()).ok());
  TypeParam measurement;
  measurement.translation()(0) = 10;
  const auto loss = std::make_shared<ceres::HuberLoss>(1);
  const typename TypeParam::Matrix I = TypeParam::Matrix::Identity();
  ASSERT_TRUE(optimizer.AddEdge(1, 2, measurement, I, loss).ok());
  EXPECT_NEAR(optimizer.EdgeErrors()[0].chi2, 100, 1e-9);
  EXPECT_NEAR(optimizer.Cost(), 2 * 10 - 1, 1e-9);
}

// As a graph, and into another optimizer, nothing is lost.
TYPED_TEST(QueryTest, ToGraphAndBack) {
  auto& optimizer = this->optimizer_;
  std::mt19937_64 rng(1);
  const TypeParam offset = RandomPose<TypeParam>(&rng, 1, 1);
  const typename TypeParam::Matrix information = RandomInformation<TypeParam>(&rng);
  const TypeParam measurement = RandomPose<TypeParam>(&rng, 5, 3);
  ASSERT_TRUE(optimizer.AddPrior(1007, measurement, information, offset).ok());
  ASSERT_TRUE(optimizer.SetFixed(1004, true).ok());
  optimizer.Update();
  const PoseGraph<TypeParam> graph = optimizer.ToGraph();
  ASSERT_EQ(graph.nodes().size(), 30u);
  ASSERT_EQ(graph.edges().size(), this->known_.graph.edges().size());
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    const auto &a = graph.edges()[k], &b = this->known_.graph.edges()[k];
    EXPECT_EQ(a.i, b.i);
    EXPECT_EQ(a.j, b.j);
    EXPECT_LT(a.measurement.LocalCoordinates(b.measurement).norm(), 1e-12);
    EXPECT_LT((a.information - b.information).norm(), 1e-12);
  }
  EXPECT_EQ(graph.nodes()[4].id, 1004);
  EXPECT_TRUE(graph.nodes()[4].fixed);
  ASSERT_EQ(graph.priors().size(), 1u);
  EXPECT_LT(graph.priors()[0].offset.LocalCoordinates(offset).norm(), 1e-12);

  Optimizer<TypeParam> copy(this->Options());
  ASSERT_TRUE(copy.AddGraph(graph).ok());
  EXPECT_NEAR(copy.Cost(), optimizer.Cost(), 1e-9 * optimizer.Cost());
  copy.ForEachPose([&](NodeId id, const TypeParam& pose) {
    EXPECT_LT(pose.LocalCoordinates(*optimizer.GetPose(id)).norm(), 1e-12) << id;
  });
}

TYPED_TEST(QueryTest, AddGraphComposesMissingPoses) {
  PoseGraph<TypeParam> graph = this->known_.graph;
  for (int k = 1; k < 30; ++k) {
    graph.node(k).has_pose = false;
    graph.node(k).pose = TypeParam();
  }
  Optimizer<TypeParam> optimizer;
  ASSERT_TRUE(optimizer.AddGraph(graph).ok());
  for (int k = 0; k < 30; ++k) {  // dead reckoning, as the graph had it
    const TypeParam& pose = this->known_.graph.nodes()[k].pose;
    EXPECT_LT(pose.LocalCoordinates(*optimizer.GetPose(1000 + k)).norm(), 1e-9) << k;
  }
}

// Every member of a group moves with it: its pose in the group's frame stays.
TYPED_TEST(QueryTest, GroupsCarryTheirMembers) {
  OptimizerOptions options = this->Options();
  options.condense_chains = false;  // those of a chain follow two groups
  Optimizer<TypeParam> optimizer(options);
  ASSERT_TRUE(optimizer.AddGraph(this->known_.graph).ok());
  optimizer.Refine();
  ASSERT_GE(optimizer.num_levels(), 3);
  for (int level = 0; level < optimizer.num_levels(); ++level) {
    for (NodeId id = 1000; id < 1030; ++id) {
      ASSERT_TRUE(optimizer.GetGroup(id, level).ok());
      EXPECT_EQ(optimizer.GetGroup(id, level)->id, optimizer.GetGroup(id, level)->id);
    }
  }
  EXPECT_LT(optimizer.GetGroup(1005, 0)->pose.LocalCoordinates(*optimizer.GetPose(1005)).norm(),
            1e-12);
  const int top = optimizer.num_levels() - 1;
  const auto group = *optimizer.GetGroup(1029, top);
  const TypeParam before = *optimizer.GetPose(1029);
  // Turn the anchored end: the other end follows as a whole.
  typename TypeParam::Tangent turn = TypeParam::Tangent::Zero();
  turn(TypeParam::kDof - 1) = 0.2;
  ASSERT_TRUE(optimizer.SetPose(1000, optimizer.GetPose(1000)->Retract(turn)).ok());
  EXPECT_TRUE(optimizer.Optimize(Mode::kTop).status.ok());
  const TypeParam after = optimizer.GetGroup(1029, top)->pose;
  EXPECT_LT(
      (after * group.pose.Inverse() * before).LocalCoordinates(*optimizer.GetPose(1029)).norm(),
      1e-9);
  ASSERT_TRUE(optimizer.AddNode(5, TypeParam()).ok());
  EXPECT_EQ(optimizer.GetGroup(5, top).status().message(), "node 5 has no group yet: update first");
}

TYPED_TEST(QueryTest, MarginalCovarianceIsTheInverseOfTheHessian) {
  using Covariance = typename TypeParam::Matrix;
  constexpr int D = TypeParam::kDof;
  OptimizerOptions options;
  options.condense_chains = false;  // else what SetPose moves is followed by the chains at it
  Optimizer<TypeParam> optimizer(options);
  const KnownGraph<TypeParam> known = MakeKnownGraph<TypeParam>(9, 0.05, 8);
  ASSERT_TRUE(optimizer.AddGraph(known.graph).ok());
  EXPECT_TRUE(optimizer.Refine().at_rest);
  // Half the second derivatives of the cost, by central differences; node 0 is held.
  constexpr double h = 1e-3;
  std::vector<TypeParam> poses;
  for (int k = 0; k < 9; ++k) poses.push_back(*optimizer.GetPose(k));
  const auto cost = [&](int a, double step_a, int b, double step_b) {
    typename TypeParam::Tangent da = TypeParam::Tangent::Zero(), db = da;
    da(a % D) = step_a;
    db(b % D) = step_b;
    const int i = 1 + a / D, j = 1 + b / D;
    EXPECT_TRUE(optimizer.SetPose(i, poses[i].Retract(i == j ? da + db : da)).ok());
    if (i != j) {
      EXPECT_TRUE(optimizer.SetPose(j, poses[j].Retract(db)).ok());
    }
    const double value = optimizer.Cost();
    EXPECT_TRUE(optimizer.SetPose(i, poses[i]).ok());
    EXPECT_TRUE(optimizer.SetPose(j, poses[j]).ok());
    return value;
  };
  Eigen::MatrixXd H(8 * D, 8 * D);
  for (int a = 0; a < 8 * D; ++a) {
    for (int b = a; b < 8 * D; ++b) {
      H(a, b) = H(b, a) =
          (cost(a, h, b, h) - cost(a, h, b, -h) - cost(a, -h, b, h) + cost(a, -h, b, -h)) /
          (8 * h * h);
    }
  }
  const Eigen::MatrixXd inverse = H.inverse();
  for (int k = 1; k < 9; ++k) {
    const Result<Covariance> covariance = optimizer.MarginalCovariance(k);
    ASSERT_TRUE(covariance.ok()) << covariance.status().ToString();
    const Covariance expected = inverse.block<D, D>((k - 1) * D, (k - 1) * D);
    // Gauss and Newton leave out the residuals' curvature, which is small here.
    EXPECT_LT((*covariance - expected).norm(), 0.05 * expected.norm()) << k;
  }
  EXPECT_EQ(*optimizer.MarginalCovariance(0), Covariance(Covariance::Zero()));
}

TYPED_TEST(QueryTest, MarginalCovarianceOfWhatIsNotDetermined) {
  Optimizer<TypeParam> optimizer;
  ASSERT_TRUE(optimizer.AddNode(1, TypeParam()).ok());
  typename TypeParam::Matrix information = TypeParam::Matrix::Identity();
  constexpr int kRotation = TypeParam::kRotationDof;
  information.template bottomRightCorner<kRotation, kRotation>().setZero();
  ASSERT_TRUE(optimizer.AddPrior(1, TypeParam(), information).ok());
  optimizer.Update();
  EXPECT_EQ(optimizer.MarginalCovariance(1).status().code(), StatusCode::kNoSolution);
}

}  // namespace
}  // namespace hpgo
