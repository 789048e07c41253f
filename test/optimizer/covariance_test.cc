// Covariances against ceres::Covariance.

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "ceres/covariance.h"
#include "ceres/problem.h"
#include "ceres_costs/relative_pose_cost.h"
#include "gtest/gtest.h"
#include "hpgo/optimizer.h"
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
using Groups = testing::Types<SE2, SE3>;
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
    const Eigen::MatrixXd expected = joint.topLeftCorner<D, D>();
    EXPECT_LT((*marginal - expected).norm(), 1e-6 * expected.norm());
    Eigen::Matrix<double, D, 2 * D> J;
    const G T = optimizer.GetPose(i)->Between(*optimizer.GetPose(j));
    J << -T.Inverse().Adjoint(), Eigen::Matrix<double, D, D>::Identity();
    const Eigen::MatrixXd relative = J * joint * J.transpose();
    const auto result = optimizer.RelativeCovariance(i, j);
    ASSERT_TRUE(result.ok()) << result.status().ToString();
    EXPECT_LT((*result - relative).norm(), 1e-6 * relative.norm());
  }
}

}  // namespace
}  // namespace hpgo
