#include "ceres_costs/relative_pose_cost.h"

#include "ceres_costs/local_jacobian_cost.h"
#include "gmock/gmock.h"
#include "test/ceres_costs/cost_checks.h"
#include "unsupported/Eigen/MatrixFunctions"

namespace ceres_costs {
namespace {

constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kTwist,
                                            ErrorConvention::kSplitLog};

template <typename G>
RelativePoseTerm<G> MakeTerm(const G& measurement, const typename G::Matrix& information) {
  return {measurement, PackedSymmetric<G::kDof>(information)};
}

template <typename G>
std::unique_ptr<ceres::CostFunction> MakeCost(const RelativePoseTerm<G>& term,
                                              ErrorConvention convention, DiffMethod method,
                                              JacobianKind jacobians) {
  std::string error;
  auto cost = MakeRelativePoseCost(term, convention, method, jacobians, &error);
  EXPECT_NE(cost, nullptr) << error;
  return cost;
}

// A term and two poses whose deviation is Exp(xi), and now and then quaternions of both signs.
template <typename G>
struct Sample {
  RelativePoseTerm<G> term;
  std::vector<G> poses;
};

template <typename G>
void FlipSign(G*) {}
void FlipSign(SE3* x) { x->rotation().coeffs() *= -1; }

template <typename G>
std::vector<Sample<G>> MakeSamples(double pi_margin) {
  std::mt19937 rng(7);
  std::vector<Sample<G>> samples;
  for (const auto& xi : SampleTangents<G>(pi_margin)) {
    const double distance = samples.size() % 3 == 0 ? 1e3 : 3;
    const G Z = RandomPose<G>(&rng, 2), X_i = RandomPose<G>(&rng, distance);
    G X_j = X_i * Z * G::Exp(xi);
    if (samples.size() % 2 == 0) FlipSign(&X_j);
    samples.push_back({MakeTerm<G>(Z, RandomInformation<G::kDof>(&rng)), {X_i, X_j}});
  }
  return samples;
}

template <typename G>
class RelativePoseCostTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(RelativePoseCostTest, Groups);

TYPED_TEST(RelativePoseCostTest, AnalyticAgreesWithNumericDifferentiation) {
  for (const auto& sample : MakeSamples<TypeParam>(1e-4)) {
    for (const ErrorConvention convention : kConventions) {
      const auto cost =
          MakeCost(sample.term, convention, DiffMethod::kAnalytic, JacobianKind::kLocal);
      ExpectNumericJacobians(*cost, sample.poses, 1e-6);
    }
  }
}

TYPED_TEST(RelativePoseCostTest, GradientCheckerAgrees) {
  std::mt19937 rng(8);
  using G = TypeParam;
  for (const double angle : {0.0, 1e-9, 0.3, 2.5}) {
    const auto xi = MakeTangent(static_cast<const G*>(nullptr), 1, angle);
    const G Z = RandomPose<G>(&rng, 2), X_i = RandomPose<G>(&rng, 3);
    const auto term = MakeTerm<G>(Z, RandomInformation<G::kDof>(&rng));
    for (const ErrorConvention convention : kConventions) {
      const auto cost = MakeCost(term, convention, DiffMethod::kAnalytic, JacobianKind::kAmbient);
      ExpectGradientCheckerAgrees<G>(*cost, {X_i, X_i * Z * G::Exp(xi)}, 1e-9);
    }
  }
}

TYPED_TEST(RelativePoseCostTest, AutomaticAgreesWithAnalytic) {
  for (const auto& sample : MakeSamples<TypeParam>(1e-9)) {
    for (const ErrorConvention convention : kConventions) {
      const auto analytic =
          MakeCost(sample.term, convention, DiffMethod::kAnalytic, JacobianKind::kAmbient);
      const auto automatic =
          MakeCost(sample.term, convention, DiffMethod::kAutomatic, JacobianKind::kAmbient);
      ExpectTwins(*analytic, *automatic, sample.poses, 1e-10);
    }
  }
}

TYPED_TEST(RelativePoseCostTest, LocalJacobiansAreThoseOfTheManifold) {
  for (const auto& sample : MakeSamples<TypeParam>(1e-9)) {
    for (const ErrorConvention convention : kConventions) {
      for (const DiffMethod method : {DiffMethod::kAnalytic, DiffMethod::kAutomatic}) {
        const auto ambient = MakeCost(sample.term, convention, method, JacobianKind::kAmbient);
        const auto local = MakeCost(sample.term, convention, method, JacobianKind::kLocal);
        ExpectLocalOf(*ambient, *local, sample.poses, 1e-12);
      }
    }
  }
}

// e' Omega e with an error made by other means: homogeneous matrices and their logarithm.
Eigen::Matrix4d Homogeneous(const SE3& T) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = Eigen::Quaterniond(T.data() + 3).toRotationMatrix();
  m.topRightCorner<3, 1>() = T.translation();
  return m;
}
Eigen::Matrix3d Homogeneous(const SE2& T) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T.angle()).toRotationMatrix();
  m.topRightCorner<2, 1>() = T.translation();
  return m;
}
Eigen::Matrix4d Homogeneous(const YawPose& T) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(T.angle()).toRotationMatrix();
  m.topRightCorner<3, 1>() = T.translation();
  return m;
}
SE3::Tangent OtherError(const SE3&, ErrorConvention convention, const Eigen::Matrix4d& D) {
  SE3::Tangent e;
  if (convention == ErrorConvention::kTwist) {
    const Eigen::Matrix4d log = D.log();
    e << log.topRightCorner<3, 1>(), log(2, 1), log(0, 2), log(1, 0);
    return e;
  }
  const Eigen::AngleAxisd rotation(Eigen::Matrix3d(D.topLeftCorner<3, 3>()));
  const double size =
      convention == ErrorConvention::kG2o ? std::sin(rotation.angle() / 2) : rotation.angle();
  e << D.topRightCorner<3, 1>(), size * rotation.axis();
  return e;
}
YawPose::Tangent OtherError(const YawPose&, ErrorConvention convention, const Eigen::Matrix4d& D) {
  const Eigen::Matrix4d log = D.log();
  if (convention == ErrorConvention::kTwist) {
    return YawPose::Tangent(log(0, 3), log(1, 3), log(2, 3), log(1, 0));
  }
  return YawPose::Tangent(D(0, 3), D(1, 3), D(2, 3), log(1, 0));
}
SE2::Tangent OtherError(const SE2&, ErrorConvention convention, const Eigen::Matrix3d& D) {
  if (convention == ErrorConvention::kTwist) {
    const Eigen::Matrix3d log = D.log();
    return SE2::Tangent(log(0, 2), log(1, 2), log(1, 0));
  }
  return SE2::Tangent(D(0, 2), D(1, 2), std::atan2(D(1, 0), D(0, 0)));
}

TYPED_TEST(RelativePoseCostTest, SquareIsTheMahalanobisDistanceWithDenseInformation) {
  using G = TypeParam;
  std::mt19937 rng(9);
  for (int k = 0; k < 30; ++k) {
    const G Z = RandomPose<G>(&rng, 5), X_i = RandomPose<G>(&rng, 5), X_j = RandomPose<G>(&rng, 5);
    const typename G::Matrix information = RandomInformation<G::kDof>(&rng);
    for (const ErrorConvention convention : kConventions) {
      const auto D =
          (Homogeneous(Z).inverse() * Homogeneous(X_i).inverse() * Homogeneous(X_j)).eval();
      const typename G::Tangent e = OtherError(Z, convention, D);
      for (const DiffMethod method : {DiffMethod::kAnalytic, DiffMethod::kAutomatic}) {
        const auto cost =
            MakeCost(MakeTerm(Z, information), convention, method, JacobianKind::kAmbient);
        const double chi2 = Residuals<G>(*cost, {X_i, X_j}).squaredNorm();
        const double expected = e.dot(information * e);
        EXPECT_NEAR(chi2, expected, 1e-9 * expected);
      }
    }
  }
}

TYPED_TEST(RelativePoseCostTest, SquareIsTheMahalanobisDistanceWithSingularInformation) {
  using G = TypeParam;
  std::mt19937 rng(10);
  const G Z = RandomPose<G>(&rng, 5), X_i = RandomPose<G>(&rng, 5), X_j = RandomPose<G>(&rng, 5);
  const typename G::Tangent e = DeviationError(ErrorConvention::kG2o, Z.Between(X_i.Between(X_j)));
  for (int rank = 0; rank < G::kDof; ++rank) {
    const typename G::Matrix information = RandomInformation<G::kDof>(&rng, rank);
    const auto cost = MakeCost(MakeTerm(Z, information), ErrorConvention::kG2o,
                               DiffMethod::kAnalytic, JacobianKind::kLocal);
    EXPECT_NEAR(Residuals<G>(*cost, {X_i, X_j}).squaredNorm(), e.dot(information * e), 1e-11);
  }
}

// X_j ahead of where the measurement has it: a positive error, in the measured frame.
TYPED_TEST(RelativePoseCostTest, SignOfTheResidual) {
  using G = TypeParam;
  std::mt19937 rng(11);
  const G Z = RandomPose<G>(&rng, 5), X_i = RandomPose<G>(&rng, 5);
  for (const ErrorConvention convention : kConventions) {
    const auto cost = MakeCost(MakeTerm<G>(Z, G::Matrix::Identity()), convention,
                               DiffMethod::kAnalytic, JacobianKind::kLocal);
    EXPECT_TRUE(IsNear(Residuals<G>(*cost, {X_i, X_i * Z}), G::Tangent::Zero(), 1e-14));
    for (int k = 0; k < G::kDof; ++k) {
      const typename G::Tangent step = 0.01 * G::Tangent::Unit(k);
      const bool half = convention == ErrorConvention::kG2o && G::kRotationDof == 3 && k >= 3;
      const Eigen::VectorXd r = Residuals<G>(*cost, {X_i, (X_i * Z).Retract(step)});
      EXPECT_TRUE(IsNear(r, (half ? 0.5 : 1) * step, 1e-6)) << "component " << k;
    }
  }
}

TYPED_TEST(RelativePoseCostTest, NullJacobiansAreLeftOut) {
  using G = TypeParam;
  std::mt19937 rng(12);
  const G X_i = RandomPose<G>(&rng, 5), X_j = RandomPose<G>(&rng, 5);
  const auto term = MakeTerm<G>(RandomPose<G>(&rng, 5), RandomInformation<G::kDof>(&rng));
  for (const DiffMethod method : {DiffMethod::kAnalytic, DiffMethod::kAutomatic}) {
    const auto cost = MakeCost(term, ErrorConvention::kTwist, method, JacobianKind::kLocal);
    Evaluation<G> full = Evaluate<G>(*cost, {X_i, X_j});
    const double* parameters[] = {X_i.data(), X_j.data()};
    for (int wanted = 0; wanted < 2; ++wanted) {
      Evaluation<G> partial = full;
      partial.jacobians[wanted].setZero();
      double* jacobians[] = {nullptr, nullptr};
      jacobians[wanted] = partial.jacobians[wanted].data();
      ASSERT_TRUE(cost->Evaluate(parameters, partial.residuals.data(), jacobians));
      EXPECT_EQ(partial.jacobians[wanted], full.jacobians[wanted]);
    }
  }
}

TYPED_TEST(RelativePoseCostTest, ResetMakesItAnotherMeasurement) {
  using G = TypeParam;
  std::mt19937 rng(13);
  const G X_i = RandomPose<G>(&rng, 5), X_j = RandomPose<G>(&rng, 5);
  RelativePoseCost<G> pooled(JacobianKind::kLocal);
  for (const ErrorConvention convention : kConventions) {
    const auto term = MakeTerm<G>(RandomPose<G>(&rng, 5), RandomInformation<G::kDof>(&rng));
    ASSERT_TRUE(pooled.Reset(term, convention));
    const auto fresh = MakeCost(term, convention, DiffMethod::kAnalytic, JacobianKind::kLocal);
    const Evaluation<G> a = Evaluate<G>(pooled, {X_i, X_j}), b = Evaluate<G>(*fresh, {X_i, X_j});
    EXPECT_EQ(a.residuals, b.residuals);
    EXPECT_EQ(a.jacobians[0], b.jacobians[0]);
    EXPECT_EQ(a.jacobians[1], b.jacobians[1]);
  }
  const Eigen::VectorXd before = Residuals<G>(pooled, {X_i, X_j});
  EXPECT_FALSE(pooled.Reset(MakeTerm<G>(G(), -G::Matrix::Identity()), ErrorConvention::kG2o));
  EXPECT_EQ(Residuals<G>(pooled, {X_i, X_j}), before);
}

TYPED_TEST(RelativePoseCostTest, NanInAPoseReachesTheResiduals) {
  using G = TypeParam;
  const G bad = WithParameter(G(), G::kParams - 1, std::nan(""));
  const auto cost = MakeCost(MakeTerm<G>(G(), G::Matrix::Identity()), ErrorConvention::kG2o,
                             DiffMethod::kAnalytic, JacobianKind::kLocal);
  EXPECT_TRUE(std::isnan(Residuals<G>(*cost, {G(), bad}).norm()));
}

TYPED_TEST(RelativePoseCostTest, RefusesWhatIsNoInformation) {
  using G = TypeParam;
  typename G::Matrix information = G::Matrix::Identity();
  information(0, 0) = -2;
  std::string error;
  for (const DiffMethod method : {DiffMethod::kAnalytic, DiffMethod::kAutomatic}) {
    EXPECT_EQ(MakeRelativePoseCost(MakeTerm(G(), information), ErrorConvention::kG2o, method,
                                   JacobianKind::kLocal, &error),
              nullptr);
    EXPECT_EQ(error, "information is not positive semi-definite, smallest eigenvalue -2");
  }
  information(0, 0) = std::nan("");
  EXPECT_EQ(MakeRelativePoseCost(MakeTerm(G(), information), ErrorConvention::kG2o,
                                 DiffMethod::kAnalytic, JacobianKind::kLocal, &error),
            nullptr);
  EXPECT_EQ(error, "information is not finite");
}

}  // namespace
}  // namespace ceres_costs
