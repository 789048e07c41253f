// One suite over all groups.
#include "ceres/jet.h"
#include "test/ceres_costs/samples.h"

namespace ceres_costs {
namespace {

SE2::Matrix RightJacobianInverse(const SE2::Tangent& xi) { return Se2RightJacobianInverse(xi); }
SE3::Matrix RightJacobianInverse(const SE3::Tangent& xi) { return Se3RightJacobianInverse(xi); }
YawPose::Matrix RightJacobianInverse(const YawPose::Tangent& xi) {
  return YawPoseRightJacobianInverse(xi);
}

// The group over jets of its own tangent's dimension.
template <typename G>
struct OverJets;
template <>
struct OverJets<SE2> {
  using Group = SE2T<ceres::Jet<double, 3>>;
};
template <>
struct OverJets<SE3> {
  using Group = SE3T<ceres::Jet<double, 6>>;
};
template <>
struct OverJets<YawPose> {
  using Group = YawPoseT<ceres::Jet<double, 4>>;
};

// The tangent with its own infinitesimals.
template <typename J>
Eigen::Matrix<J, J::DIMENSION, 1> Variable(const Eigen::Matrix<double, J::DIMENSION, 1>& value) {
  Eigen::Matrix<J, J::DIMENSION, 1> d;
  for (int k = 0; k < J::DIMENSION; ++k) d(k) = J(value(k), k);
  return d;
}

template <int N>
Eigen::Matrix<double, N, N> Derivative(const Eigen::Matrix<ceres::Jet<double, N>, N, 1>& d) {
  Eigen::Matrix<double, N, N> J;
  for (int k = 0; k < N; ++k) J.row(k) = d(k).v.transpose();
  return J;
}

template <typename J, int R, int C>
Eigen::Matrix<double, R, C> Value(const Eigen::Matrix<J, R, C>& m) {
  return m.unaryExpr([](const J& x) { return x.a; });
}
template <typename J>
SE2 Value(const SE2T<J>& x) {
  return SE2(x.data()[0].a, x.data()[1].a, x.data()[2].a);
}
template <typename J>
YawPose Value(const YawPoseT<J>& x) {
  return YawPose(x.data()[0].a, x.data()[1].a, x.data()[2].a, x.data()[3].a);
}
template <typename J>
SE3 Value(const SE3T<J>& x) {
  SE3 value;
  for (int k = 0; k < SE3::kParams; ++k) value.data()[k] = x.data()[k].a;
  return value;
}

template <typename G>
class GroupTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(GroupTest, Groups);

TYPED_TEST(GroupTest, ProductActsAsItsFactorsDo) {
  using G = TypeParam;
  std::mt19937 rng(1);
  for (int k = 0; k < 50; ++k) {
    const G a = RandomPose<G>(&rng, 10), b = RandomPose<G>(&rng, 1e3);
    const typename G::Vector p = RandomPose<G>(&rng, 5).translation();
    EXPECT_TRUE(IsNear((a * b) * p, a * (b * p), 1e-10));
    EXPECT_TRUE(IsNear(a * p, a.matrix() * p + a.translation(), 1e-12));
    EXPECT_TRUE(IsNear(a.matrix() * a.matrix().transpose(), G::RotationMatrix::Identity(), 1e-14));
    EXPECT_NEAR(a.matrix().determinant(), 1, 1e-14);
  }
}

TYPED_TEST(GroupTest, InverseAndBetween) {
  using G = TypeParam;
  std::mt19937 rng(2);
  for (const G& a : SamplePoses<G>(1e-9)) {
    const G b = RandomPose<G>(&rng, 100);
    EXPECT_TRUE(IsSamePose(a * a.Inverse(), G(), 1e-12 * (1 + a.translation().norm())));
    EXPECT_TRUE(IsSamePose(a.Between(b), a.Inverse() * b, 1e-12));
    EXPECT_TRUE(IsSamePose(a * a.Between(b), b, 1e-11));
  }
}

TYPED_TEST(GroupTest, LogInvertsExp) {
  using G = TypeParam;
  for (const auto& xi : SampleTangents<G>(1e-9)) {
    const G T = G::Exp(xi);
    EXPECT_TRUE(IsNear(T.Log(), xi, 1e-14 + 1e-12 * xi.norm())) << xi.transpose();
    EXPECT_TRUE(IsSamePose(G::Exp(T.Log()), T, 1e-12)) << xi.transpose();
  }
}

TYPED_TEST(GroupTest, TinyTwistsKeepTheirDigits) {
  using G = TypeParam;
  for (const double size : {1e-12, 1e-10, 1e-8, 1e-6}) {
    const auto xi = MakeTangent(static_cast<const G*>(nullptr), size, size);
    EXPECT_TRUE(IsNear(G::Exp(xi).Log(), xi, 1e-15 * size));
    EXPECT_TRUE(IsNear(G().LocalCoordinates(G().Retract(xi)), xi, 1e-15 * size));
  }
}

TYPED_TEST(GroupTest, ExpIsTheLimitOfSmallSteps) {
  using G = TypeParam;
  const auto xi = MakeTangent(static_cast<const G*>(nullptr), 3, 2.9);
  G product;
  for (int k = 0; k < 1 << 20; ++k) product = product.Retract(xi / (1 << 20));
  EXPECT_TRUE(IsSamePose(product, G::Exp(xi), 1e-5));
}

// `plus` and `minus` undo each other, from random poses.
template <typename G, typename PlusFunction, typename MinusFunction>
void ExpectInverse(const PlusFunction& plus, const MinusFunction& minus, double rounding) {
  std::mt19937 rng(3);
  for (const auto& d : SampleTangents<G>(1e-9)) {
    const G x = RandomPose<G>(&rng, 10);
    EXPECT_TRUE(IsNear(minus(plus(x, d), x), d, rounding * (10 + d.norm()))) << d.transpose();
    const G y = RandomPose<G>(&rng, 10);
    EXPECT_TRUE(IsSamePose(plus(x, minus(y, x)), y, rounding));
  }
}

TYPED_TEST(GroupTest, LocalCoordinatesInvertRetract) {
  using G = TypeParam;
  ExpectInverse<G>([](const G& x, const auto& d) { return x.Retract(d); },
                   [](const G& y, const G& x) { return x.LocalCoordinates(y); }, 1e-13);
}

TYPED_TEST(GroupTest, MinusInvertsPlus) {
  using G = TypeParam;
  ExpectInverse<G>([](const G& x, const auto& d) { return x.Plus(d); },
                   [](const G& y, const G& x) { return y.Minus(x); }, 1e-12);
}

// However far: half a turn about a point 100 m away.
TYPED_TEST(GroupTest, PosesMovedByOneMotionOfTheWorldKeepTheirRelativePose) {
  using G = TypeParam;
  std::mt19937 rng(8);
  const auto motion = MakeTangent(static_cast<const G*>(nullptr), 300, 2.9);
  for (int k = 0; k < 20; ++k) {
    const G x = RandomPose<G>(&rng, 100), y = RandomPose<G>(&rng, 100);
    const G x_moved = x.Plus(x.InverseAdjoint() * motion);
    const G y_moved = y.Plus(y.InverseAdjoint() * motion);
    EXPECT_TRUE(IsSamePose(x_moved.Between(y_moved), x.Between(y), 1e-11));
    EXPECT_TRUE(IsSamePose(x_moved, G::Exp(motion) * x, 1e-11));
  }
}

TYPED_TEST(GroupTest, AdjointMovesAPerturbationToTheOtherSide) {
  using G = TypeParam;
  std::mt19937 rng(4);
  const auto d = MakeTangent(static_cast<const G*>(nullptr), 0.5, 1.2);
  for (const G& T : SamplePoses<G>(1e-9)) {
    const double scale = 1 + T.translation().norm();
    EXPECT_TRUE(IsSamePose(T * G::Exp(d), G::Exp(T.Adjoint() * d) * T, 1e-12));
    EXPECT_TRUE(IsNear(T.Adjoint() * T.Inverse().Adjoint(), G::Matrix::Identity(), 1e-12 * scale));
    EXPECT_TRUE(IsNear(T.InverseAdjoint(), T.Inverse().Adjoint(), 1e-14 * scale));
    const G b = RandomPose<G>(&rng, 3);
    EXPECT_TRUE(IsNear((T * b).Adjoint(), T.Adjoint() * b.Adjoint(), 1e-12 * scale));
  }
}

TYPED_TEST(GroupTest, RetractAgreesWithExpToFirstOrder) {
  using G = TypeParam;
  using JetGroup = typename OverJets<G>::Group;
  using Jet = typename JetGroup::Scalar;
  const auto zero = Variable<Jet>(G::Tangent::Zero());
  for (const G& T : SamplePoses<G>(1e-9)) {
    const JetGroup x = T.template Cast<Jet>();
    const JetGroup a = x.Retract(zero), b = x * JetGroup::Exp(zero);
    for (int k = 0; k < G::kParams; ++k) {
      EXPECT_TRUE(IsNear(a.data()[k].v, b.data()[k].v, 1e-12)) << "parameter " << k;
    }
  }
}

TYPED_TEST(GroupTest, RightJacobianInverseAgreesWithJets) {
  using G = TypeParam;
  using JetGroup = typename OverJets<G>::Group;
  using Jet = typename JetGroup::Scalar;
  const auto zero = Variable<Jet>(G::Tangent::Zero());
  for (const auto& xi : SampleTangents<G>(1e-9)) {
    const JetGroup T = G::Exp(xi).template Cast<Jet>() * JetGroup::Exp(zero);
    EXPECT_TRUE(
        IsNear(RightJacobianInverse(xi), Derivative(T.Log()), 1e-10 * std::max(1.0, xi.norm())))
        << xi.transpose();
  }
}

TYPED_TEST(GroupTest, RightJacobianInverseAgreesWithNumericDifferentiation) {
  using G = TypeParam;
  for (const auto& xi : SampleTangents<G>(1e-3)) {
    const G T = G::Exp(xi);
    typename G::Matrix numeric;
    for (int k = 0; k < G::kDof; ++k) {
      const typename G::Tangent step = 1e-5 * G::Tangent::Unit(k);
      numeric.col(k) = ((T * G::Exp(step)).Log() - (T * G::Exp(-step)).Log()) / 2e-5;
    }
    EXPECT_TRUE(IsNear(RightJacobianInverse(xi), numeric, 1e-7 * std::max(1.0, xi.norm())))
        << xi.transpose();
  }
}

TYPED_TEST(GroupTest, JetsHoldTheValuesOfDoubles) {
  using G = TypeParam;
  using JetGroup = typename OverJets<G>::Group;
  using Jet = typename JetGroup::Scalar;
  std::mt19937 rng(5);
  for (const auto& xi : SampleTangents<G>(1e-9)) {
    const auto jets = Variable<Jet>(xi);
    const G a = RandomPose<G>(&rng, 10), b = G::Exp(xi);
    const JetGroup ja = a.template Cast<Jet>(), jb = JetGroup::Exp(jets);
    EXPECT_TRUE(IsSamePose(Value(jb), b, 1e-14));
    EXPECT_TRUE(IsNear(Value(jb.Log()), b.Log(), 1e-14 * (1 + xi.norm())));
    EXPECT_TRUE(IsSamePose(Value(ja.Retract(jets)), a.Retract(xi), 1e-14));
    EXPECT_TRUE(IsSamePose(Value(ja * jb), a * b, 1e-14));
    EXPECT_TRUE(IsSamePose(Value(ja.Between(jb)), a.Between(b), 1e-14));
    EXPECT_TRUE(
        IsNear(Value(ja.LocalCoordinates(jb)), a.LocalCoordinates(b), 1e-13 * (1 + xi.norm())));
    EXPECT_TRUE(IsNear(Value(jb.Adjoint()), b.Adjoint(), 1e-14 * (1 + xi.norm())));
    // Log undoes Exp, so its derivative through both is the identity.
    EXPECT_TRUE(IsNear(Derivative(jb.Log()), G::Matrix::Identity(), 1e-12 * (1 + xi.norm())))
        << xi.transpose();
  }
}

TYPED_TEST(GroupTest, NanStaysNan) {
  using G = TypeParam;
  const auto xi = MakeTangent(static_cast<const G*>(nullptr), 1, std::nan(""));
  const typename G::Tangent log = G::Exp(xi).Log();
  for (int k = 0; k < G::kDof; ++k) {
    const bool upright_z = G::kDof == 4 && k == 2;  // has nothing to do with the angle
    EXPECT_EQ(std::isnan(log(k)), !upright_z) << k;
  }
  EXPECT_TRUE(RightJacobianInverse(xi).array().isNaN().any());
}

TEST(NormalizeAngleTest, KeepsWhatIsInsideBitForBit) {
  for (const double angle : {0.0, 1e-300, 0.1, -3.0, kPi, -kPi}) {
    EXPECT_EQ(NormalizeAngle(angle), angle);
  }
}

TEST(NormalizeAngleTest, WrapsWhatIsOutside) {
  EXPECT_NEAR(NormalizeAngle(3 * kPi - 0.5), kPi - 0.5, 1e-14);
  EXPECT_NEAR(NormalizeAngle(kPi + 0.25), -kPi + 0.25, 1e-14);
  EXPECT_NEAR(NormalizeAngle(-kPi - 0.25), kPi - 0.25, 1e-14);
  EXPECT_NEAR(NormalizeAngle(2e6 * kPi + 1), 1, 1e-9);
  EXPECT_TRUE(std::isnan(NormalizeAngle(std::nan(""))));
}

TEST(So3Test, RightJacobianTimesItsInverse) {
  for (const auto& d : SampleTangents<SE3>(1e-9)) {
    const Eigen::Vector3d phi = d.tail<3>();
    EXPECT_TRUE(IsNear(So3RightJacobian(phi) * So3RightJacobianInverse(phi),
                       Eigen::Matrix3d::Identity(), 1e-13));
  }
}

TEST(So3Test, LogTakesTheShorterWay) {
  const Eigen::Vector3d phi(0, 0, kPi + 0.1);
  EXPECT_TRUE(IsNear(So3Log(So3Exp(phi)), Eigen::Vector3d(0, 0, 0.1 - kPi), 1e-14));
}

}  // namespace
}  // namespace ceres_costs
