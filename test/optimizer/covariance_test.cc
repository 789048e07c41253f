// Covariances against ceres::Covariance.

#include <algorithm>
#include <array>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "ceres/covariance.h"
#include "ceres/problem.h"
#include "ceres_costs/relative_pose_cost.h"
#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/optimizer.h"
#include "hpgo/replay.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

// The optimizer's graph as a ceres::Problem, its first node held.
template <typename G>
class CeresReference {
 public:
  explicit CeresReference(const PoseGraph<G>& graph) {
    for (const GraphNode<G>& node : graph.nodes()) {
      poses_.emplace_back();
      std::copy_n(node.pose.data(), G::kParams, poses_.back().data());
    }
    for (auto& pose : poses_) {
      problem_.AddParameterBlock(
          pose.data(), G::kParams,
          ceres_costs::MakePoseManifold<G>(ceres_costs::JacobianKind::kAmbient).release());
    }
    problem_.SetParameterBlockConstant(poses_[0].data());
    for (const GraphEdge<G>& edge : graph.edges()) {
      std::string error;
      auto cost = ceres_costs::MakeRelativePoseCost<G>(
          {edge.measurement, ceres_costs::PackedSymmetric<G::kDof>(edge.information)},
          ceres_costs::ErrorConvention::kG2o, ceres_costs::DiffMethod::kAnalytic,
          ceres_costs::JacobianKind::kAmbient, &error);
      EXPECT_NE(cost, nullptr) << error;
      problem_.AddResidualBlock(cost.release(), nullptr, poses_[edge.i].data(),
                                poses_[edge.j].data());
    }
  }
  // The joint covariance of two poses.
  Eigen::MatrixXd Joint(int i, int j) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    ceres::Covariance covariance(options);
    const std::vector<const double*> blocks = {poses_[i].data(), poses_[j].data()};
    EXPECT_TRUE(covariance.Compute(blocks, &problem_));
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> joint(2 * G::kDof,
                                                                                 2 * G::kDof);
    EXPECT_TRUE(covariance.GetCovarianceMatrixInTangentSpace(blocks, joint.data()));
    return joint;
  }

 private:
  std::vector<std::array<double, G::kParams>> poses_;
  ceres::Problem problem_;
};

template <typename G>
class CovarianceTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(CovarianceTest, Groups);

TYPED_TEST(CovarianceTest, EqualsThatOfCeres) {
  using G = TypeParam;
  constexpr int D = G::kDof;
  Optimizer<G> optimizer;
  ASSERT_TRUE(optimizer.AddGraph(MakeKnownGraph<G>(80, 0.05, 4).graph).ok());
  ASSERT_TRUE(optimizer.Converge().at_rest);
  CeresReference<G> reference(optimizer.ToGraph());
  for (const auto& [i, j] : {std::pair(3, 70), std::pair(40, 41), std::pair(79, 20)}) {
    const Eigen::MatrixXd joint = reference.Joint(i, j);
    const auto marginal = optimizer.MarginalCovariance(i);
    ASSERT_TRUE(marginal.ok()) << marginal.status().ToString();
    const Eigen::MatrixXd expected = joint.topLeftCorner(D, D);
    EXPECT_LT((*marginal - expected).norm(), 1e-6 * expected.norm());
    const G T = optimizer.GetPose(i)->Between(*optimizer.GetPose(j));
    Eigen::MatrixXd J(D, 2 * D);
    J.leftCols(D) = -T.Inverse().Adjoint();
    J.rightCols(D).setIdentity();
    const Eigen::MatrixXd relative = J * joint * J.transpose();
    const auto result = optimizer.RelativeCovariance(i, j);
    ASSERT_TRUE(result.ok()) << result.status().ToString();
    EXPECT_LT((*result - relative).norm(), 1e-6 * relative.norm());
  }
}

// But for 1e-4.
bool IsUpperBound(const Eigen::MatrixXd& bound, const Eigen::MatrixXd& covariance) {
  const Eigen::MatrixXd above = (1 + 1e-4) * bound - covariance;
  return above.llt().info() == Eigen::Success;
}

template <typename G>
Optimizer<G> DriveThroughCity(int nodes) {
  GenerateOptions options;
  options.world = World::kCity;
  options.nodes = nodes;
  const PoseGraph<G> graph = GenerateGraph<G>(options)->graph;
  Optimizer<G> optimizer;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    EXPECT_TRUE(ApplyStep<G>(graph, step, nullptr, &optimizer).ok());
    optimizer.Update();
  }
  EXPECT_TRUE(optimizer.Refine().at_rest);
  return optimizer;
}

template <typename G>
class CityCovarianceTest : public testing::Test {};
using GeneratedGroups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(CityCovarianceTest, GeneratedGroups);

TYPED_TEST(CityCovarianceTest, TheBoundedOnesAreExactWhereAllIsInside) {
  using G = TypeParam;
  const Optimizer<G> optimizer = DriveThroughCity<G>(1500);
  // Kept nodes, insides of chains, two of the same chain in both orders, the free end.
  for (const auto& [i, j] : {std::pair(1499, 3), std::pair(700, 705), std::pair(1203, 1201),
                             std::pair(0, 1490), std::pair(40, 900)}) {
    const auto marginal = optimizer.BoundedMarginalCovariance(i);
    ASSERT_TRUE(marginal.ok()) << marginal.status().ToString();
    EXPECT_TRUE(marginal->exact);
    EXPECT_LT(marginal->nodes, 300);
    const auto expected = *optimizer.MarginalCovariance(i);
    EXPECT_LE((marginal->covariance - expected).norm(), 1e-4 * expected.norm()) << i;
    const auto relative = optimizer.BoundedRelativeCovariance(i, j);
    ASSERT_TRUE(relative.ok()) << relative.status().ToString();
    EXPECT_TRUE(relative->exact);
    const auto between = *optimizer.RelativeCovariance(i, j);
    EXPECT_LE((relative->covariance - between).norm(), 1e-4 * between.norm()) << i << " " << j;
  }
}

TYPED_TEST(CityCovarianceTest, TheBoundedOnesAreUpperBounds) {
  using G = TypeParam;
  const Optimizer<G> optimizer = DriveThroughCity<G>(3000);
  for (const auto& [i, j] : {std::pair(2999, 3), std::pair(1700, 1705), std::pair(40, 2900)}) {
    for (const int max_nodes : {0, 20, 100}) {
      const auto marginal = optimizer.BoundedMarginalCovariance(i, max_nodes);
      ASSERT_TRUE(marginal.ok()) << marginal.status().ToString();
      EXPECT_FALSE(marginal->exact);
      EXPECT_TRUE(IsUpperBound(marginal->covariance, *optimizer.MarginalCovariance(i)))
          << i << ", " << marginal->nodes;
      const auto relative = optimizer.BoundedRelativeCovariance(i, j, max_nodes);
      ASSERT_TRUE(relative.ok()) << relative.status().ToString();
      EXPECT_TRUE(IsUpperBound(relative->covariance, *optimizer.RelativeCovariance(i, j)))
          << i << " " << j << ", " << relative->nodes;
    }
  }
}

TYPED_TEST(CovarianceTest, BoundedOnesOfWhatIsHeldOrNotThereYet) {
  using G = TypeParam;
  Optimizer<G> optimizer;
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(optimizer.AddNode(k, G()).ok());
  for (int k = 1; k < 5; ++k) {
    ASSERT_TRUE(optimizer.AddEdge(k - 1, k, G(), G::Matrix::Identity()).ok());
  }
  const auto expect_exact = [&](NodeId id) {
    const auto bounded = optimizer.BoundedMarginalCovariance(id);
    ASSERT_TRUE(bounded.ok()) << bounded.status().ToString();
    EXPECT_TRUE(bounded->exact);
    EXPECT_LE((bounded->covariance - *optimizer.MarginalCovariance(id)).norm(), 1e-9);
  };
  EXPECT_EQ(optimizer.BoundedMarginalCovariance(3).status().code(), StatusCode::kNoSolution);
  optimizer.Update();
  expect_exact(3);
  EXPECT_EQ(optimizer.BoundedMarginalCovariance(5).status().code(), StatusCode::kNoSolution);
  EXPECT_EQ(optimizer.BoundedRelativeCovariance(2, 5).status().code(), StatusCode::kNoSolution);
  EXPECT_EQ(optimizer.BoundedMarginalCovariance(9).status().code(), StatusCode::kNotFound);
  const auto backwards = optimizer.BoundedRelativeCovariance(3, 1);
  ASSERT_TRUE(backwards.ok()) << backwards.status().ToString();
  EXPECT_LE((backwards->covariance - *optimizer.RelativeCovariance(3, 1)).norm(), 1e-9);
  ASSERT_TRUE(optimizer.SetFixed(2, true).ok());
  optimizer.Update();
  expect_exact(4);
  EXPECT_EQ(optimizer.BoundedMarginalCovariance(2)->covariance.norm(), 0);
}

TYPED_TEST(CovarianceTest, BoundedOnesEndAtWhatIsHeld) {
  using G = TypeParam;
  OptimizerOptions options;
  options.condense_chains = false;
  Optimizer<G> optimizer(options);
  for (int k = 0; k < 50; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, G()).ok());
    if (k == 0) continue;
    ASSERT_TRUE(optimizer.AddEdge(k - 1, k, G(), G::Matrix::Identity()).ok());
  }
  const auto expect_exact = [&](NodeId id, int max_nodes) {
    const auto bounded = optimizer.BoundedMarginalCovariance(id, max_nodes);
    ASSERT_TRUE(bounded.ok()) << bounded.status().ToString();
    EXPECT_TRUE(bounded->exact);
    const auto exact = *optimizer.MarginalCovariance(id);
    EXPECT_LE((bounded->covariance - exact).norm(), 1e-9 * exact.norm());
  };
  ASSERT_TRUE(optimizer.AddPrior(0, G(), G::Matrix::Identity()).ok());
  optimizer.Update();
  expect_exact(40, 50);
  // What lies beyond a fixed node has no say.
  ASSERT_TRUE(optimizer.SetFixed(25, true).ok());
  optimizer.Update();
  expect_exact(40, 25);
}

// The way goes down through groups, which hang together whatever has been removed.
TYPED_TEST(CityCovarianceTest, BoundedOnesFindTheirWayWhereEdgesHaveGone) {
  using G = TypeParam;
  GenerateOptions generate;
  generate.world = World::kManhattan;
  generate.nodes = 400;
  const PoseGraph<G> graph = GenerateGraph<G>(generate)->graph;
  OptimizerOptions options;
  options.max_top_nodes = 10;
  Optimizer<G> optimizer(options);
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<G>(graph, step, nullptr, &optimizer).ok());
  }
  std::vector<GraphEdge<G>> edges = graph.edges();
  std::mt19937_64 rng(3);
  std::shuffle(edges.begin(), edges.end(), rng);
  int determined = 0;
  for (std::size_t k = 0; k < edges.size(); ++k) {
    ASSERT_TRUE(optimizer.RemoveEdges(edges[k].i, edges[k].j).ok());
    if (k % 20 != 0) continue;
    optimizer.Update();
    for (NodeId id = 0; id < 400; id += 37) {
      if (optimizer.EdgesOf(id)->empty()) continue;
      const bool expected = optimizer.MarginalCovariance(id).ok();
      EXPECT_EQ(optimizer.BoundedMarginalCovariance(id, 20).ok(), expected) << id;
      determined += expected;
    }
  }
  EXPECT_GT(determined, 100);
}

}  // namespace
}  // namespace hpgo
