#include "ceres_costs/prior_cost.h"

#include "gmock/gmock.h"
#include "test/ceres_costs/cost_checks.h"

namespace ceres_costs {
namespace {

constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kTwist,
                                            ErrorConvention::kSplitLog};

template <typename G>
std::unique_ptr<ceres::CostFunction> MakeCost(const RelativePoseTerm<G>& term, const G* offset,
                                              ErrorConvention convention, DiffMethod method,
                                              JacobianKind jacobians) {
  std::string error;
  auto cost = MakePriorCost(term, offset, convention, method, jacobians, &error);
  EXPECT_NE(cost, nullptr) << error;
  return cost;
}

// A prior and a pose whose deviation Z^-1 X P is Exp(xi).
template <typename G>
struct Sample {
  RelativePoseTerm<G> term;
  G offset;
  G pose;
};

template <typename G>
std::vector<Sample<G>> MakeSamples(double pi_margin) {
  std::mt19937 rng(7);
  std::vector<Sample<G>> samples;
  for (const auto& xi : SampleTangents<G>(pi_margin)) {
    const double distance = samples.size() % 3 == 0 ? 1e3 : 3;
    const G P = RandomPose<G>(&rng, 2), X = RandomPose<G>(&rng, distance);
    const G Z = X * P * G::Exp(xi).Inverse();
    samples.push_back({{Z, PackedSymmetric<G::kDof>(RandomInformation<G::kDof>(&rng))}, P, X});
  }
  return samples;
}

template <typename G>
class PriorCostTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(PriorCostTest, Groups);

TYPED_TEST(PriorCostTest, AnalyticAgreesWithNumericDifferentiation) {
  using G = TypeParam;
  for (const auto& sample : MakeSamples<G>(1e-4)) {
    for (const ErrorConvention convention : kConventions) {
      const auto cost = MakeCost(sample.term, &sample.offset, convention, DiffMethod::kAnalytic,
                                 JacobianKind::kLocal);
      ExpectNumericJacobians<G>(*cost, {sample.pose}, 1e-6);
    }
  }
}

TYPED_TEST(PriorCostTest, GradientCheckerAgrees) {
  using G = TypeParam;
  std::mt19937 rng(8);
  for (const double angle : {0.0, 1e-9, 0.3, 2.5}) {
    const auto xi = MakeTangent(static_cast<const G*>(nullptr), 1, angle);
    const G P = RandomPose<G>(&rng, 2), X = RandomPose<G>(&rng, 3);
    const RelativePoseTerm<G> term{X * P * G::Exp(xi).Inverse(),
                                   PackedSymmetric<G::kDof>(RandomInformation<G::kDof>(&rng))};
    for (const ErrorConvention convention : kConventions) {
      const auto cost =
          MakeCost(term, &P, convention, DiffMethod::kAnalytic, JacobianKind::kAmbient);
      ExpectGradientCheckerAgrees<G>(*cost, {X}, 1e-9);
    }
  }
}

TYPED_TEST(PriorCostTest, AutomaticAgreesWithAnalytic) {
  using G = TypeParam;
  for (const auto& sample : MakeSamples<G>(1e-9)) {
    for (const ErrorConvention convention : kConventions) {
      for (const G* offset : {&sample.offset, static_cast<const G*>(nullptr)}) {
        const auto analytic = MakeCost(sample.term, offset, convention, DiffMethod::kAnalytic,
                                       JacobianKind::kAmbient);
        const auto automatic = MakeCost(sample.term, offset, convention, DiffMethod::kAutomatic,
                                        JacobianKind::kAmbient);
        ExpectTwins<G>(*analytic, *automatic, {sample.pose}, 1e-10);
      }
    }
  }
}

TYPED_TEST(PriorCostTest, LocalJacobiansAreThoseOfTheManifold) {
  using G = TypeParam;
  for (const auto& sample : MakeSamples<G>(1e-9)) {
    for (const ErrorConvention convention : kConventions) {
      for (const DiffMethod method : {DiffMethod::kAnalytic, DiffMethod::kAutomatic}) {
        const auto ambient =
            MakeCost(sample.term, &sample.offset, convention, method, JacobianKind::kAmbient);
        const auto local =
            MakeCost(sample.term, &sample.offset, convention, method, JacobianKind::kLocal);
        ExpectLocalOf<G>(*ambient, *local, {sample.pose}, 1e-12);
      }
    }
  }
}

TYPED_TEST(PriorCostTest, WithoutOffsetItIsTheRelativeCostFromTheWorld) {
  using G = TypeParam;
  for (const auto& sample : MakeSamples<G>(1e-9)) {
    for (const ErrorConvention convention : kConventions) {
      PriorCost<G> prior(JacobianKind::kLocal);
      RelativePoseCost<G> relative(JacobianKind::kLocal);
      ASSERT_TRUE(prior.Reset(sample.term, nullptr, convention));
      ASSERT_TRUE(relative.Reset(sample.term, convention));
      const Evaluation<G> a = Evaluate<G>(prior, {sample.pose});
      const Evaluation<G> b = Evaluate<G>(relative, {G(), sample.pose});
      EXPECT_TRUE(IsNear(a.residuals, b.residuals, 1e-12 * Scale(a.residuals)));
      EXPECT_TRUE(IsNear(a.jacobians[0], b.jacobians[1], 1e-12 * Scale(a.jacobians[0])));
    }
  }
}

TYPED_TEST(PriorCostTest, SquareIsTheMahalanobisDistanceWithDenseInformation) {
  using G = TypeParam;
  std::mt19937 rng(9);
  for (int k = 0; k < 30; ++k) {
    const G Z = RandomPose<G>(&rng, 5), X = RandomPose<G>(&rng, 5), P = RandomPose<G>(&rng, 5);
    const typename G::Matrix information = RandomInformation<G::kDof>(&rng);
    for (const ErrorConvention convention : kConventions) {
      const typename G::Tangent e = DeviationError(convention, Z.Inverse() * X * P);
      const auto cost = MakeCost({Z, PackedSymmetric<G::kDof>(information)}, &P, convention,
                                 DiffMethod::kAnalytic, JacobianKind::kLocal);
      EXPECT_NEAR(Residuals<G>(*cost, {X}).squaredNorm(), e.dot(information * e), 1e-9);
    }
  }
}

// As a position receiver on a lever arm gives: the residual is that of the receiver's position, and
// the pose may turn about it at no cost.
TYPED_TEST(PriorCostTest, PositionOfAnOffsetSensor) {
  using G = TypeParam;
  std::mt19937 rng(10);
  const G X = RandomPose<G>(&rng, 5), P = RandomPose<G>(&rng, 2);
  G Z;  // measured without a rotation
  Z.translation() = RandomPose<G>(&rng, 5).translation();
  typename G::Matrix information = G::Matrix::Zero();
  using Corner = Eigen::Matrix<double, G::kDim, G::kDim>;
  const Corner position =
      RandomInformation<G::kDof>(&rng).template topLeftCorner<G::kDim, G::kDim>();
  information.template topLeftCorner<G::kDim, G::kDim>() = position;
  const auto cost = MakeCost({Z, PackedSymmetric<G::kDof>(information)}, &P, ErrorConvention::kG2o,
                             DiffMethod::kAnalytic, JacobianKind::kLocal);
  const typename G::Vector miss = X * typename G::Vector(P.translation()) - Z.translation();
  EXPECT_NEAR(Residuals<G>(*cost, {X}).squaredNorm(), miss.dot(position * miss), 1e-11);

  const Evaluation<G> at = Evaluate<G>(*cost, {X});
  const auto J = at.jacobians[0].template leftCols<G::kDof>();
  Eigen::FullPivLU<typename G::Matrix> lu(J.transpose() * J);
  EXPECT_EQ(lu.setThreshold(1e-9).rank(), int{G::kDim});
  const typename G::Tangent turn =
      P.Adjoint() * G::Tangent::Unit(G::kDof - 1);  // about the sensor's last axis
  EXPECT_NEAR((J * turn).norm(), 0, 1e-12);
}

TYPED_TEST(PriorCostTest, SignOfTheResidual) {
  using G = TypeParam;
  std::mt19937 rng(11);
  const G Z = RandomPose<G>(&rng, 5), P = RandomPose<G>(&rng, 2);
  const RelativePoseTerm<G> term{Z, PackedSymmetric<G::kDof>(G::Matrix::Identity())};
  for (const ErrorConvention convention : kConventions) {
    const auto cost = MakeCost(term, &P, convention, DiffMethod::kAnalytic, JacobianKind::kLocal);
    for (int k = 0; k < G::kDof; ++k) {
      const typename G::Tangent step = 0.01 * G::Tangent::Unit(k);
      const bool half = convention == ErrorConvention::kG2o && G::kRotationDof == 3 && k >= 3;
      const G X = Z.Retract(step) * P.Inverse();
      EXPECT_TRUE(IsNear(Residuals<G>(*cost, {X}), (half ? 0.5 : 1) * step, 1e-6)) << k;
    }
  }
}

TYPED_TEST(PriorCostTest, ResetMakesItAnotherMeasurement) {
  using G = TypeParam;
  PriorCost<G> pooled(JacobianKind::kAmbient);
  for (const auto& sample : MakeSamples<G>(1e-9)) {
    for (const G* offset : {&sample.offset, static_cast<const G*>(nullptr)}) {
      ASSERT_TRUE(pooled.Reset(sample.term, offset, ErrorConvention::kSplitLog));
      const auto fresh = MakeCost(sample.term, offset, ErrorConvention::kSplitLog,
                                  DiffMethod::kAnalytic, JacobianKind::kAmbient);
      const Evaluation<G> a = Evaluate<G>(pooled, {sample.pose});
      const Evaluation<G> b = Evaluate<G>(*fresh, {sample.pose});
      EXPECT_EQ(a.residuals, b.residuals);
      EXPECT_EQ(a.jacobians[0], b.jacobians[0]);
    }
  }
}

TYPED_TEST(PriorCostTest, RefusesWhatIsNoInformation) {
  using G = TypeParam;
  RelativePoseTerm<G> term{G(), PackedSymmetric<G::kDof>(-G::Matrix::Identity())};
  std::string error;
  EXPECT_EQ(MakePriorCost<G>(term, nullptr, ErrorConvention::kG2o, DiffMethod::kAnalytic,
                             JacobianKind::kLocal, &error),
            nullptr);
  EXPECT_EQ(error, "information is not positive semi-definite, smallest eigenvalue -1");
  PriorCost<G> cost;
  EXPECT_FALSE(cost.Reset(term, nullptr, ErrorConvention::kG2o));
}

}  // namespace
}  // namespace ceres_costs
