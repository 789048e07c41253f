// What mappers ask of the optimizer: edges by their ends, the frame of an information matrix, nodes
// posed in an estimate that is no longer the optimizer's, the optimum at once.

#include <memory>
#include <vector>

#include "ceres/loss_function.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/replay.h"
#include "test/optimizer/mapper_calls_fixture.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

TYPED_TEST_SUITE(MapperCallsTest, MapperCallsGroups);

TYPED_TEST(MapperCallsTest, EdgesByTheirEnds) {
  auto& optimizer = this->optimizer_;
  const auto& I = this->I_;
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(optimizer.AddNode(k, TypeParam()).ok());
  const EdgeId a = *optimizer.AddEdge(0, 1, TypeParam(), I);
  const EdgeId b = *optimizer.AddEdge(1, 2, TypeParam(), I);
  const EdgeId c = *optimizer.AddEdge(2, 1, TypeParam(), I);
  const EdgeId prior = *optimizer.AddPrior(1, TypeParam(), I);
  const EdgeId d = *optimizer.AddEdge(2, 3, TypeParam(), I);
  EXPECT_THAT(this->Ids(optimizer.EdgesOf(1)), testing::ElementsAre(a, b, c, prior));
  EXPECT_EQ((*optimizer.EdgesOf(1))[2].i, 2);
  EXPECT_EQ((*optimizer.EdgesOf(1))[2].j, 1);
  EXPECT_EQ((*optimizer.EdgesOf(1))[3].i, 1);
  EXPECT_EQ((*optimizer.EdgesOf(1))[3].j, 1);
  EXPECT_EQ(optimizer.EdgesOf(9).status().message(), "no node 9");

  EXPECT_THAT(this->Ids(optimizer.RemoveEdges(1, 3)), testing::IsEmpty());
  EXPECT_THAT(this->Ids(optimizer.RemoveEdges(2, 1)), testing::ElementsAre(b, c));
  EXPECT_THAT(this->Ids(optimizer.EdgesOf(1)), testing::ElementsAre(a, prior));
  EXPECT_EQ(optimizer.RemoveEdges(1, 9).status().message(), "no node 9");
  EXPECT_EQ(optimizer.RemoveEdges(1, 1).status().message(), "edge 1 -> 1: a self edge");
  EXPECT_THAT(this->Ids(optimizer.RemoveNode(1)), testing::ElementsAre(a, prior));
  EXPECT_THAT(this->Ids(optimizer.EdgesOf(2)), testing::ElementsAre(d));
  EXPECT_EQ(optimizer.num_edges(), 1u);
}

TYPED_TEST(MapperCallsTest, UpdateEdgeChangesTheLossToo) {
  auto& optimizer = this->optimizer_;
  const auto& I = this->I_;
  ASSERT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
  ASSERT_TRUE(optimizer.AddNode(1, TypeParam()).ok());
  TypeParam Z;
  Z.translation()(0) = 10;
  const EdgeId edge = *optimizer.AddEdge(0, 1, Z, I);
  EXPECT_NEAR(optimizer.Cost(), 100, 1e-9);
  optimizer.Update();  // a chain now, which cannot have a loss
  ASSERT_TRUE(optimizer.UpdateEdge(edge, Z, I, std::make_shared<ceres::HuberLoss>(1)).ok());
  EXPECT_EQ(optimizer.FindInconsistency(), "");
  ASSERT_TRUE(optimizer.SetPose(1, TypeParam()).ok());
  EXPECT_NEAR(optimizer.Cost(), 2 * 10 - 1, 1e-9);
  optimizer.Update();
  EXPECT_EQ(optimizer.FindInconsistency(), "");
  ASSERT_TRUE(optimizer.SetPose(1, TypeParam()).ok());
  EXPECT_NEAR(optimizer.Cost(), 2 * 10 - 1, 1e-9);
  Z.translation()(0) = 5;
  ASSERT_TRUE(optimizer.UpdateEdge(edge, Z, I).ok());  // keeps it
  EXPECT_NEAR(optimizer.Cost(), 2 * 5 - 1, 1e-9);
  ASSERT_TRUE(optimizer.UpdateEdge(edge, Z, I, nullptr).ok());
  EXPECT_NEAR(optimizer.Cost(), 25, 1e-9);
}

TYPED_TEST(MapperCallsTest, InformationInTheFrameOfTheFirstNode) {
  constexpr int D = TypeParam::kDof, kDim = TypeParam::kDim;
  for (int trial = 0; trial < 20; ++trial) {
    Optimizer<TypeParam> optimizer;
    const TypeParam X_i = RandomPose<TypeParam>(&this->rng_, 5, 3);
    const TypeParam Z = RandomPose<TypeParam>(&this->rng_, 5, 3);
    const TypeParam T = Z * RandomPose<TypeParam>(&this->rng_, 0.5, 1e-9);
    const auto information = RandomInformation<TypeParam>(&this->rng_);
    ASSERT_TRUE(optimizer.AddNode(0, X_i).ok());
    ASSERT_TRUE(optimizer.AddNode(1, X_i * T).ok());
    const EdgeId edge = *optimizer.AddEdge(0, 1, Z, information, nullptr, InfoFrame::kFirstNode);
    Eigen::Matrix<double, D, 1> e = Eigen::Matrix<double, D, 1>::Zero();
    e.template head<kDim>() = T.translation() - Z.translation();
    const double chi2 = e.dot(information * e);
    EXPECT_NEAR(optimizer.Cost(), chi2, 1e-6 * chi2);
    ASSERT_TRUE(optimizer.UpdateEdge(edge, Z, 2 * information, InfoFrame::kFirstNode).ok());
    EXPECT_NEAR(optimizer.Cost(), 2 * chi2, 1e-6 * chi2);
  }
}

// An update between a node and its first edge: the client's pose is not thrown away.
TYPED_TEST(MapperCallsTest, ANodeWithoutEdgesKeepsItsPose) {
  auto& optimizer = this->optimizer_;
  ASSERT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
  ASSERT_TRUE(optimizer.AddNode(1, TypeParam()).ok());
  ASSERT_TRUE(optimizer.AddEdge(0, 1, TypeParam(), this->I_).ok());
  optimizer.Update();
  typename TypeParam::Tangent off = TypeParam::Tangent::Constant(0.1);
  const TypeParam pose = TypeParam().Retract(off);
  ASSERT_TRUE(optimizer.AddNode(2, pose).ok());
  optimizer.Update();
  EXPECT_LT(this->Distance(*optimizer.GetPose(2), pose), 1e-12);
  // An edge that says little about where it is leaves it there.
  ASSERT_TRUE(optimizer.AddEdge(1, 2, TypeParam(), 1e-9 * this->I_).ok());
  ASSERT_TRUE(optimizer.AddPrior(2, pose, this->I_).ok());
  optimizer.Update();
  EXPECT_LT(this->Distance(*optimizer.GetPose(2), pose), 1e-6);
  EXPECT_LT(optimizer.Cost(), 1e-6);
}

// Two nodes without edges become one component, held once.
TYPED_TEST(MapperCallsTest, NodesWithoutEdgesJoin) {
  auto& optimizer = this->optimizer_;
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, RandomPose<TypeParam>(&this->rng_, 1, 0.1)).ok());
    optimizer.Update();
  }
  const TypeParam first = *optimizer.GetPose(0);
  const TypeParam Z = RandomPose<TypeParam>(&this->rng_, 1, 0.1);
  ASSERT_TRUE(optimizer.AddEdge(0, 1, Z, this->I_).ok());
  ASSERT_TRUE(optimizer.AddEdge(1, 2, Z, this->I_).ok());
  EXPECT_TRUE(optimizer.Refine().at_rest);
  EXPECT_LT(this->Distance(*optimizer.GetPose(0), first), 1e-12);
  EXPECT_LT(optimizer.Cost(), 1e-9);
}

// Each new node at a pose composed from an estimate that the client has never brought up to date.
TYPED_TEST(MapperCallsTest, NodesPosedInAStaleEstimateAreTakenInAtOnce) {
  GenerateOptions options;
  options.world = World::kCity;
  options.nodes = 3000;
  const SyntheticGraph<TypeParam> world = *GenerateGraph<TypeParam>(options);
  for (const int batch : {1, 50}) {
    auto optimizer = Optimizer<TypeParam>();
    std::vector<TypeParam> stale(options.nodes);
    int count = 0;
    for (const ReplayStep& step : ReplaySteps(world.graph)) {
      stale[step.node] =
          StartPose<TypeParam>(world.graph, step, [&](int node) -> Result<TypeParam> {
            return stale[node];
          })->Normalized();
      ASSERT_TRUE(
          AddStep<TypeParam>(world.graph, step, stale[step.node], nullptr, &optimizer).ok());
      if (++count % batch == 0) optimizer.Update();
    }
    EXPECT_LT(Gap(optimizer), 0.5) << batch;
  }
}

// Hundreds of nodes at once, dead reckoning with loops.
TYPED_TEST(MapperCallsTest, ConvergeReachesTheOptimum) {
  auto& optimizer = this->optimizer_;
  const KnownGraph<TypeParam> known = MakeKnownGraph<TypeParam>(600, 0.02, 4);
  ASSERT_TRUE(optimizer.AddGraph(known.graph).ok());
  const UpdateReport report = optimizer.Converge();
  EXPECT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_TRUE(report.at_rest);
  EXPECT_EQ(report.new_nodes, 600);
  EXPECT_LT(Gap(optimizer), 1e-8);
  EXPECT_EQ(optimizer.Converge().windows, 0);  // nothing has changed
  EXPECT_TRUE(optimizer.Converge().at_rest);
  ASSERT_TRUE(optimizer.AddEdge(3, 400, known.truth[3].Between(known.truth[400]), this->I_).ok());
  EXPECT_GT(optimizer.Converge().windows, 0);
  EXPECT_LT(Gap(optimizer), 1e-8);
}

TYPED_TEST(MapperCallsTest, ConvergeKeepsToItsLimits) {
  auto& optimizer = this->optimizer_;
  const KnownGraph<TypeParam> known = MakeKnownGraph<TypeParam>(600, 0.02, 4);
  ASSERT_TRUE(optimizer.AddGraph(known.graph).ok());
  UpdateLimits limits;
  limits.max_cpu_seconds = 1e-7;  // one window is solved at least
  UpdateReport report = optimizer.Converge(limits);
  EXPECT_FALSE(report.at_rest);
  EXPECT_EQ(report.windows + report.top_solves, 1);
  limits.max_cpu_seconds = 1000;
  report = optimizer.Converge(limits);
  EXPECT_TRUE(report.at_rest);
  EXPECT_LT(Gap(optimizer), 1e-8);
}

// Against the covariance of the whole, another node's direction being measured by nothing.
TYPED_TEST(MapperCallsTest, CovarianceDespiteAnUndeterminedNode) {
  constexpr int D = TypeParam::kDof, kRotation = TypeParam::kRotationDof;
  const KnownGraph<TypeParam> known = MakeKnownGraph<TypeParam>(30, 0.02, 9);
  auto& optimizer = this->optimizer_;
  ASSERT_TRUE(optimizer.AddGraph(known.graph).ok());
  ASSERT_TRUE(optimizer.Converge().at_rest);
  const auto before = *optimizer.MarginalCovariance(20);
  const auto relative_before = *optimizer.RelativeCovariance(7, 25);
  // From the joint covariance with respect to 7: held, 25 is known relative to it as well.
  ASSERT_TRUE(optimizer.SetFixed(7, true).ok());
  ASSERT_TRUE(optimizer.SetFixed(0, true).ok());
  ASSERT_TRUE(optimizer.SetFixed(0, false).ok());
  optimizer.Update();
  const auto held = *optimizer.MarginalCovariance(25);
  EXPECT_LT((held - relative_before).norm(), 1e-6 * held.norm());
  EXPECT_EQ((*optimizer.RelativeCovariance(7, 25) - held).norm(), 0);
  ASSERT_TRUE(optimizer.SetFixed(0, true).ok());
  ASSERT_TRUE(optimizer.SetFixed(7, false).ok());
  optimizer.Update();
  // A node seen without its orientation; and one whose orientation is seen along a mixture only.
  typename TypeParam::Matrix information = this->I_;
  information.template bottomRightCorner<kRotation, kRotation>().setZero();
  ASSERT_TRUE(optimizer.AddNode(100, *optimizer.GetPose(3)).ok());
  ASSERT_TRUE(optimizer.AddEdge(3, 100, TypeParam(), information).ok());
  const Eigen::Matrix<double, D, 1> along = Eigen::Matrix<double, D, 1>::LinSpaced(D, 1, 2);
  ASSERT_TRUE(optimizer.AddNode(101, *optimizer.GetPose(5)).ok());
  ASSERT_TRUE(optimizer.AddEdge(5, 101, TypeParam(), along * along.transpose()).ok());
  EXPECT_EQ(optimizer.MarginalCovariance(100).status().code(), StatusCode::kNoSolution);
  EXPECT_EQ(optimizer.MarginalCovariance(101).status().code(), StatusCode::kNoSolution);
  const auto after = optimizer.MarginalCovariance(20);
  ASSERT_TRUE(after.ok()) << after.status().ToString();
  EXPECT_LT((*after - before).norm(), 1e-6 * before.norm());
  const auto relative_after = optimizer.RelativeCovariance(7, 25);
  ASSERT_TRUE(relative_after.ok()) << relative_after.status().ToString();
  EXPECT_LT((*relative_after - relative_before).norm(), 1e-6 * relative_before.norm());
}

}  // namespace
}  // namespace hpgo
