// The models of factors, and how they are transported.

#include "ceres_costs/factor_term.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>

#include "ceres_costs/losses.h"
#include "ceres_costs/symmetric_eigen.h"
#include "test/ceres_costs/factor_samples.h"

namespace ceres_costs {
namespace {

template <typename G>
class FactorTermTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FactorTermTest, Groups);

TYPED_TEST(FactorTermTest, ModelAgreesWithNumericDifferentiation) {
  using G = TypeParam;
  ForEveryFactor<G>(
      [](const FactorTerm<G>& factor, bool unary, const G& T, const std::string& label) {
        QuadraticModel<G> model;
        ASSERT_TRUE(LinearizeFactor(factor, unary, T, &model));
        EXPECT_TRUE(IsSameModel(model, NumericModel(factor, T), 1e-7)) << label;
        EXPECT_TRUE(IsNear(model.A, model.A.transpose(), 1e-12 * Scale(model))) << label;
      });
}

TYPED_TEST(FactorTermTest, CostIsThatOfTheModel) {
  using G = TypeParam;
  ForEveryFactor<G>(
      [](const FactorTerm<G>& factor, bool unary, const G& T, const std::string& label) {
        QuadraticModel<G> model;
        ASSERT_TRUE(LinearizeFactor(factor, unary, T, &model));
        EXPECT_NEAR(FactorCost(factor, unary, T), model.cost, 1e-12 * Scale(model)) << label;
      });
}

TYPED_TEST(FactorTermTest, GradientIsThatOfTheCost) {
  using G = TypeParam;
  ForEveryFactor<G>(
      [](const FactorTerm<G>& factor, bool unary, const G& T, const std::string& label) {
        const double h = 1e-5;
        QuadraticModel<G> model;
        ASSERT_TRUE(LinearizeFactor(factor, unary, T, &model));
        typename G::Tangent gradient;
        for (int k = 0; k < G::kDof; ++k) {
          const typename G::Tangent step = h * G::Tangent::Unit(k);
          gradient(k) = (FactorCost<G>(factor, unary, T.Retract(step)) -
                         FactorCost<G>(factor, unary, T.Retract(-step))) /
                        (2 * h);
        }
        EXPECT_TRUE(IsNear(2 * model.b, gradient, 1e-6 * Scale(model))) << label;
      });
}

// The exact second derivative along b, where the curvature of rho acts, at an error so small that
// Gauss-Newton is exact otherwise.
TYPED_TEST(FactorTermTest, UsesTheCurvatureOfALossOnlyWhereItIsPositive) {
  using G = TypeParam;
  std::mt19937 rng(6);
  const G Z = RandomPose<G>(&rng, 3);
  const double weight = 1e6;
  const RelativePoseTerm<G> term{Z, PackedSymmetric<G::kDof>(weight * G::Matrix::Identity())};
  const G T = Z * G::Exp(MakeTangent(static_cast<const G*>(nullptr), 1e-3, 1e-3));
  std::unique_ptr<ceres::LossFunction> cauchy;
  std::string error;
  ASSERT_TRUE(MakeLoss("cauchy", 1, &cauchy, &error)) << error;
  const GrowingLoss growing;
  FactorTerm<G> factor;
  factor.term = &term;
  QuadraticModel<G> plain, model;
  ASSERT_TRUE(LinearizeFactor(factor, false, T, &plain));
  double rho[3];

  factor.loss = cauchy.get();
  ASSERT_TRUE(LinearizeFactor(factor, false, T, &model));
  cauchy->Evaluate(plain.cost, rho);
  ASSERT_LT(rho[2], 0);
  EXPECT_TRUE(IsNear(model.A, rho[1] * plain.A, 1e-9 * weight));
  EXPECT_GE(EigenvaluesOf<G::kDof>(model.A)(0), 0);

  factor.loss = &growing;
  ASSERT_TRUE(LinearizeFactor(factor, false, T, &model));
  const typename G::Tangent along = plain.b.normalized();
  const double h = 1e-5;
  const auto cost = [&](double s) {
    return FactorCost<G>(factor, false, T.Retract(typename G::Tangent(s * along)));
  };
  const double second = (cost(h) - 2 * cost(0) + cost(-h)) / (h * h);
  EXPECT_NEAR(2 * along.dot(model.A * along), second, 1e-2 * second);
}

TYPED_TEST(FactorTermTest, ChangeIsThatOfTheWhitenedError) {
  using G = TypeParam;
  std::mt19937 rng(7);
  ForEveryFactor<G>(
      [&](const FactorTerm<G>& factor, bool unary, const G& T, const std::string& label) {
        const G T1 = T * RandomPose<G>(&rng, 0.1);
        const typename G::Matrix omega = factor.term->information.Dense();
        const typename G::Tangent e1 = ErrorAt(factor, T1);
        const typename G::Tangent d = e1 - ErrorAt(factor, T);
        double rho[3] = {0, 1, 0};
        if (factor.loss != nullptr) factor.loss->Evaluate(e1.dot(omega * e1), rho);
        const double expected = std::sqrt(std::max(0., rho[1] * d.dot(omega * d)));
        EXPECT_NEAR(FactorChange(factor, unary, T, T1), expected, 1e-7 * (1 + expected)) << label;
        EXPECT_EQ(FactorChange(factor, unary, T, T), 0) << label;
      });
}

TYPED_TEST(FactorTermTest, TransportIsByTheAdjoint) {
  using G = TypeParam;
  std::mt19937 rng(8);
  for (int k = 0; k < 50; ++k) {
    const G T = RandomPose<G>(&rng, k % 5 == 0 ? 1000 : 3);
    QuadraticModel<G> in, expected, out;
    in.A = RandomInformation<G::kDof>(&rng, 1 + k % G::kDof);
    in.b = in.A * typename G::Tangent(T.Log());
    in.cost = k;
    const typename G::Matrix M = T.Adjoint();
    expected.A = M.transpose() * in.A * M;
    expected.b = M.transpose() * in.b;
    expected.cost = k;
    TransportModel(T, in, &out);
    EXPECT_TRUE(IsSameModel(out, expected, 1e-13));
    TransportModel(G(), in, &out);
    EXPECT_TRUE(IsSameModel(out, in, 1e-15));
  }
}

// As solvers use it: the model by a perturbation of the first pose of an edge.
TYPED_TEST(FactorTermTest, TransportGivesTheModelOfTheOtherEnd) {
  using G = TypeParam;
  std::mt19937 rng(9);
  for (const Sample<G>& sample : MakeSamples<G>()) {
    FactorTerm<G> factor;
    factor.term = &sample.term;
    const G X_i = RandomPose<G>(&rng, 5), X_j = X_i * sample.T_i_j;
    QuadraticModel<G> at_j, at_i;
    ASSERT_TRUE(LinearizeFactor(factor, false, sample.T_i_j, &at_j));
    TransportModel(sample.T_i_j.Inverse(), at_j, &at_i);
    const double h = 1e-5;
    typename G::Matrix J;
    for (int k = 0; k < G::kDof; ++k) {
      const typename G::Tangent step = h * G::Tangent::Unit(k);
      J.col(k) = (ErrorAt<G>(factor, X_i.Retract(step).Between(X_j)) -
                  ErrorAt<G>(factor, X_i.Retract(-step).Between(X_j))) /
                 (2 * h);
    }
    const typename G::Matrix omega = factor.term->information.Dense();
    const double tolerance = 1e-7 * Scale(at_i);
    EXPECT_TRUE(IsNear(at_i.A, J.transpose() * omega * J, tolerance));
    EXPECT_TRUE(IsNear(-at_i.b, J.transpose() * omega * ErrorAt(factor, sample.T_i_j), tolerance));
    EXPECT_EQ(at_i.cost, at_j.cost);
  }
}

TEST(FactorTermTest3d, TheSignOfAQuaternionDoesNotMatter) {
  for (const Sample<SE3>& sample : MakeSamples<SE3>()) {
    for (const ErrorConvention convention : kConventions) {
      SE3 negated = sample.T_i_j;
      for (int k = 3; k < 7; ++k) negated.data()[k] *= -1;
      FactorTerm<SE3> factor;
      factor.term = &sample.term;
      factor.convention = convention;
      QuadraticModel<SE3> a, b;
      ASSERT_TRUE(LinearizeFactor(factor, false, sample.T_i_j, &a));
      ASSERT_TRUE(LinearizeFactor(factor, false, negated, &b));
      EXPECT_TRUE(IsSameModel(a, b, 1e-13));
    }
  }
}

}  // namespace
}  // namespace ceres_costs
