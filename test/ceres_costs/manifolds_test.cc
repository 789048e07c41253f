#include "ceres_costs/manifolds.h"

#include <algorithm>
#include <array>

#include "ceres/problem.h"
#include "ceres/solver.h"
#include "ceres_costs/relative_pose_cost.h"
#include "test/ceres_costs/samples.h"

namespace ceres_costs {
namespace {

template <typename G>
using AmbientByLocal = Eigen::Matrix<double, G::kParams, G::kDof, Eigen::RowMajor>;
template <typename G>
using LocalByAmbient = Eigen::Matrix<double, G::kDof, G::kParams, Eigen::RowMajor>;

template <typename G>
using Stored = Eigen::Map<const Eigen::Matrix<double, G::kParams, 1>>;

template <typename G>
G Plus(const ceres::Manifold& manifold, const G& x, const typename G::Tangent& d) {
  double y[G::kParams];
  EXPECT_TRUE(manifold.Plus(x.data(), d.data(), y));
  return G(y);
}
template <typename G>
typename G::Tangent Minus(const ceres::Manifold& manifold, const G& y, const G& x) {
  typename G::Tangent d;
  EXPECT_TRUE(manifold.Minus(y.data(), x.data(), d.data()));
  return d;
}

template <typename G>
class ManifoldTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(ManifoldTest, Groups);

TYPED_TEST(ManifoldTest, PlusAndMinusAreInverse) {
  using G = TypeParam;
  std::mt19937 rng(1);
  for (const JacobianKind kind : {JacobianKind::kAmbient, JacobianKind::kLocal}) {
    const auto manifold = MakePoseManifold<G>(kind);
    EXPECT_EQ(manifold->AmbientSize(), int{G::kParams});
    EXPECT_EQ(manifold->TangentSize(), int{G::kDof});
    for (const G& x : SamplePoses<G>(1e-9)) {
      const double scale = 1 + x.translation().norm();
      EXPECT_TRUE(IsNear(Stored<G>(Plus<G>(*manifold, x, G::Tangent::Zero()).data()),
                         Stored<G>(x.data()), 1e-15 * scale));
      EXPECT_TRUE(IsNear(Minus(*manifold, x, x), G::Tangent::Zero(), 1e-15));
      for (const auto& d : SampleTangents<G>(1e-9)) {
        EXPECT_TRUE(
            IsNear(Minus(*manifold, Plus(*manifold, x, d), x), d, 1e-12 * (scale + d.norm())));
      }
      const G y = RandomPose<G>(&rng, 10);
      EXPECT_TRUE(IsSamePose(Plus(*manifold, x, Minus(*manifold, y, x)), y, 1e-12 * scale));
    }
  }
}

TYPED_TEST(ManifoldTest, PlusGoesAlongTheExponential) {
  using G = TypeParam;
  for (const JacobianKind kind : {JacobianKind::kAmbient, JacobianKind::kLocal}) {
    const auto manifold = MakePoseManifold<G>(kind);
    for (const G& x : SamplePoses<G>(1e-9)) {
      for (const auto& d : SampleTangents<G>(1e-9)) {
        const double scale = 1 + x.translation().norm() + d.norm();
        EXPECT_TRUE(IsSamePose(Plus(*manifold, x, d), x * G::Exp(d), 1e-12 * scale));
      }
    }
  }
}

TYPED_TEST(ManifoldTest, PlusJacobianAgreesWithNumericDifferentiation) {
  using G = TypeParam;
  const PoseManifold<G> manifold;
  for (const G& x : SamplePoses<G>(1e-3)) {
    AmbientByLocal<G> P;
    ASSERT_TRUE(manifold.PlusJacobian(x.data(), P.data()));
    const double h = 1e-5;
    for (int k = 0; k < G::kDof; ++k) {
      const typename G::Tangent step = h * G::Tangent::Unit(k);
      const G a = Plus<G>(manifold, x, step), b = Plus<G>(manifold, x, -step);
      const double scale = 1 + x.translation().norm();
      EXPECT_TRUE(
          IsNear(P.col(k), (Stored<G>(a.data()) - Stored<G>(b.data())) / (2 * h), 1e-9 * scale))
          << "column " << k;
    }
  }
}

TYPED_TEST(ManifoldTest, MinusJacobianAgreesWithNumericDifferentiation) {
  using G = TypeParam;
  const PoseManifold<G> manifold;
  for (const G& x : SamplePoses<G>(1e-3)) {
    LocalByAmbient<G> M;
    ASSERT_TRUE(manifold.MinusJacobian(x.data(), M.data()));
    const double h = 1e-5;
    for (int k = 0; k < G::kParams; ++k) {
      const G a = WithParameter(x, k, x.data()[k] + h), b = WithParameter(x, k, x.data()[k] - h);
      // Minus is defined on the manifold: a quaternion off unit norm counts as its direction.
      const typename G::Tangent numeric =
          (Minus(manifold, a.Normalized(), x) - Minus(manifold, b.Normalized(), x)) / (2 * h);
      EXPECT_TRUE(IsNear(M.col(k), numeric, 1e-8 * (1 + x.translation().norm()))) << "column " << k;
    }
  }
}

TYPED_TEST(ManifoldTest, MinusJacobianInvertsPlusJacobian) {
  using G = TypeParam;
  for (const JacobianKind kind : {JacobianKind::kAmbient, JacobianKind::kLocal}) {
    const auto manifold = MakePoseManifold<G>(kind);
    for (const G& x : SamplePoses<G>(1e-9)) {
      AmbientByLocal<G> P;
      LocalByAmbient<G> M;
      ASSERT_TRUE(manifold->PlusJacobian(x.data(), P.data()));
      ASSERT_TRUE(manifold->MinusJacobian(x.data(), M.data()));
      EXPECT_TRUE(IsNear(M * P, G::Matrix::Identity(), 1e-15 * 4));
    }
  }
}

TYPED_TEST(ManifoldTest, LocalPlusJacobianSelectsTheFirstColumns) {
  using G = TypeParam;
  const LocalPoseManifold<G> manifold;
  AmbientByLocal<G> P;
  ASSERT_TRUE(manifold.PlusJacobian(SamplePoses<G>(0.1).back().data(), P.data()));
  EXPECT_EQ(P, (AmbientByLocal<G>::Identity()));
}

TYPED_TEST(ManifoldTest, RotationsStayNormalized) {
  using G = TypeParam;
  const LocalPoseManifold<G> manifold;
  const auto d = MakeTangent(static_cast<const G*>(nullptr), 0.1, 0.3);
  G x;
  for (int k = 0; k < 100000; ++k) x = Plus<G>(manifold, x, d);
  EXPECT_TRUE(IsNear(x.matrix() * x.matrix().transpose(), G::RotationMatrix::Identity(), 1e-14));
}

// Both ways through Ceres to the same optimum: a square whose last side does not close.
TYPED_TEST(ManifoldTest, SolvesAreEqualOnBothManifolds) {
  using G = TypeParam;
  std::mt19937 rng(2);
  std::vector<RelativePoseTerm<G>> terms;
  for (int k = 0; k < 5; ++k) {
    terms.push_back(
        {RandomPose<G>(&rng, 2), PackedSymmetric<G::kDof>(RandomInformation<G::kDof>(&rng))});
  }
  const std::pair<int, int> ends[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {1, 3}};
  const auto solve = [&](JacobianKind kind, DiffMethod method, std::vector<G>* poses) {
    std::array<std::array<double, G::kParams>, 4> x;
    ceres::Problem problem;
    for (auto& pose : x) {
      std::copy_n(G().data(), G::kParams, pose.data());
      problem.AddParameterBlock(pose.data(), G::kParams, MakePoseManifold<G>(kind).release());
    }
    problem.SetParameterBlockConstant(x.front().data());
    for (int k = 0; k < 5; ++k) {
      std::string error;
      auto cost = MakeRelativePoseCost(terms[k], ErrorConvention::kG2o, method, kind, &error);
      problem.AddResidualBlock(cost.release(), nullptr, x[ends[k].first].data(),
                               x[ends[k].second].data());
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
    options.max_num_iterations = 200;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    EXPECT_TRUE(summary.IsSolutionUsable()) << summary.BriefReport();
    EXPECT_LT(summary.final_cost, 0.9 * summary.initial_cost);
    poses->clear();
    for (const auto& pose : x) poses->push_back(G(pose.data()));
    return summary.final_cost;
  };
  std::vector<G> reference, poses;
  const double cost = solve(JacobianKind::kAmbient, DiffMethod::kAutomatic, &reference);
  for (const auto& [kind, method] : {std::pair(JacobianKind::kAmbient, DiffMethod::kAnalytic),
                                     std::pair(JacobianKind::kLocal, DiffMethod::kAutomatic),
                                     std::pair(JacobianKind::kLocal, DiffMethod::kAnalytic)}) {
    EXPECT_NEAR(solve(kind, method, &poses), cost, 1e-9 * cost);
    for (int k = 0; k < 4; ++k) EXPECT_TRUE(IsSamePose(poses[k], reference[k], 1e-5));
  }
}

}  // namespace
}  // namespace ceres_costs
