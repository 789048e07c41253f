#include "ceres_costs/factor_term.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "Eigen/Eigenvalues"
#include "ceres/autodiff_cost_function.h"
#include "ceres_costs/losses.h"
#include "ceres_costs/prior_cost.h"
#include "ceres_costs/relative_pose_cost.h"
#include "test/ceres_costs/samples.h"

namespace ceres_costs {
namespace {

constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kTwist,
                                            ErrorConvention::kSplitLog};

// rho(s) = s + s^2 / 2: grows faster than the square, its second derivative is 1.
class GrowingLoss final : public ceres::LossFunction {
 public:
  void Evaluate(double s, double rho[3]) const override {
    rho[0] = s + s * s / 2;
    rho[1] = 1 + s;
    rho[2] = 1;
  }
};

std::vector<std::unique_ptr<ceres::LossFunction>> Losses() {
  std::vector<std::unique_ptr<ceres::LossFunction>> losses(1);  // none
  for (const char* name : {"huber", "cauchy", "tukey", "geman_mcclure", "dcs"}) {
    std::string error;
    EXPECT_TRUE(MakeLoss(name, 0.8, &losses.emplace_back(), &error)) << error;
  }
  losses.push_back(std::make_unique<GrowingLoss>());
  return losses;
}

template <typename G>
double Scale(const QuadraticModel<G>& model) {
  return 1 + std::abs(model.cost) + model.A.cwiseAbs().maxCoeff() + model.b.cwiseAbs().maxCoeff();
}

template <typename G>
testing::AssertionResult IsSameModel(const QuadraticModel<G>& a, const QuadraticModel<G>& b,
                                     double tolerance) {
  const double absolute = tolerance * Scale(b);
  if (!(std::abs(a.cost - b.cost) <= absolute)) {
    return testing::AssertionFailure() << "cost " << a.cost << " against " << b.cost;
  }
  const testing::AssertionResult vector = IsNear(a.b, b.b, absolute);
  if (!vector) return vector;
  return IsNear(a.A, b.A, absolute);
}

// The error from its definition, e(Z^-1 T P).
template <typename G>
typename G::Tangent ErrorAt(const FactorTerm<G>& factor, const G& T) {
  const G P = factor.offset == nullptr ? G() : *factor.offset;
  return DeviationError(factor.convention, factor.term->measurement.Inverse() * T * P);
}

// The model from numeric derivatives of the error.
template <typename G>
QuadraticModel<G> NumericModel(const FactorTerm<G>& factor, const G& T) {
  const double h = 1e-5;
  typename G::Matrix J;
  for (int k = 0; k < G::kDof; ++k) {
    const typename G::Tangent step = h * G::Tangent::Unit(k);
    J.col(k) = (ErrorAt(factor, T.Retract(step)) - ErrorAt<G>(factor, T.Retract(-step))) / (2 * h);
  }
  const typename G::Matrix omega = factor.term->information.Dense();
  const typename G::Tangent e = ErrorAt(factor, T);
  QuadraticModel<G> model;
  model.A = J.transpose() * omega * J;
  model.b = J.transpose() * omega * e;
  model.cost = e.dot(omega * e);
  if (factor.loss == nullptr) return model;
  double rho[3];
  factor.loss->Evaluate(model.cost, rho);
  model.A = rho[1] * model.A +
            2 * std::max(0., rho[2]) * typename G::Matrix(model.b * model.b.transpose());
  model.b *= rho[1];
  model.cost = rho[0];
  return model;
}

// Terms, offsets and relative poses at which they are evaluated: the deviation is of every size,
// errors are about one so that losses matter.
template <typename G>
struct Sample {
  RelativePoseTerm<G> term;
  G offset;
  G T_i_j;
};

template <typename G>
std::vector<Sample<G>> MakeSamples() {
  std::mt19937 rng(5);
  std::vector<Sample<G>> samples;
  for (const double angle : {0.0, 1e-9, 1e-4, 0.05, 0.7, 2.5, -2.9}) {
    for (const double distance : {0.0, 0.1, 3.0}) {
      const auto xi = MakeTangent(static_cast<const G*>(nullptr), distance, angle);
      const G T = RandomPose<G>(&rng, 4), P = RandomPose<G>(&rng, 2);
      const int rank = samples.size() % 4 == 3 ? G::kDim : G::kDof;
      const typename G::Matrix information = RandomInformation<G::kDof>(&rng, rank);
      samples.push_back(
          {{T * P * G::Exp(xi).Inverse(), PackedSymmetric<G::kDof>(information)}, P, T});
    }
  }
  return samples;
}

// Calls check(factor, unary, T_i_j, label) for every combination of sample, convention, loss and,
// for priors, offset.
template <typename G, typename Check>
void ForEveryFactor(const Check& check) {
  const auto losses = Losses();
  for (const Sample<G>& sample : MakeSamples<G>()) {
    for (const ErrorConvention convention : kConventions) {
      for (std::size_t k = 0; k < losses.size(); ++k) {
        FactorTerm<G> factor;
        factor.term = &sample.term;
        factor.convention = convention;
        factor.loss = losses[k].get();
        const std::string label = "convention " + std::to_string(static_cast<int>(convention)) +
                                  ", loss " + std::to_string(k);
        // Without the offset the deviation is a random one.
        check(factor, false, sample.T_i_j, label + ", edge");
        check(factor, true, sample.T_i_j, label + ", prior");
        factor.offset = &sample.offset;
        check(factor, true, sample.T_i_j, label + ", prior with an offset");
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

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
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<typename G::Matrix>(model.A).eigenvalues()(0), 0);

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

// The built-in costs through Jets, as if they were somebody else's.
TYPED_TEST(FactorTermTest, ACustomCostGivesTheSameAsItsTerm) {
  using G = TypeParam;
  std::mt19937 rng(10);
  ForEveryFactor<G>(
      [&](const FactorTerm<G>& factor, bool unary, const G& T, const std::string& label) {
        std::string error;
        const auto cost =
            unary ? MakePriorCost(*factor.term, factor.offset, factor.convention,
                                  DiffMethod::kAutomatic, JacobianKind::kAmbient, &error)
                  : MakeRelativePoseCost(*factor.term, factor.convention, DiffMethod::kAutomatic,
                                         JacobianKind::kAmbient, &error);
        ASSERT_NE(cost, nullptr) << error;
        FactorTerm<G> custom;
        custom.custom = cost.get();
        custom.loss = factor.loss;
        QuadraticModel<G> expected, model;
        ASSERT_TRUE(LinearizeFactor(factor, unary, T, &expected));
        ASSERT_TRUE(LinearizeFactor(custom, unary, T, &model));
        EXPECT_TRUE(IsSameModel(model, expected, 1e-9)) << label;
        EXPECT_NEAR(FactorCost(custom, unary, T), expected.cost, 1e-9 * Scale(expected)) << label;
        const G T1 = T * RandomPose<G>(&rng, 0.1);
        const double change = FactorChange(factor, unary, T, T1);
        EXPECT_NEAR(FactorChange(custom, unary, T, T1), change, 1e-6 * (1 + change)) << label;
      });
}

// The distance between two poses: one residual, which no term can express.
template <typename G>
struct DistanceError {
  template <typename S>
  bool operator()(const S* i, const S* j, S* residual) const {
    using std::sqrt;
    S squares(0);
    for (int k = 0; k < G::kDim; ++k) squares += (i[k] - j[k]) * (i[k] - j[k]);
    residual[0] = 2.0 * (sqrt(squares) - 1.5);
    return true;
  }
};

TYPED_TEST(FactorTermTest, ACustomCostMayHaveFewerResiduals) {
  using G = TypeParam;
  const ceres::AutoDiffCostFunction<DistanceError<G>, 1, G::kParams, G::kParams> cost(
      new DistanceError<G>);
  FactorTerm<G> factor;
  factor.custom = &cost;
  std::mt19937 rng(11);
  const G T = RandomPose<G>(&rng, 3);
  const double distance = T.translation().norm(), r = 2 * (distance - 1.5);
  typename G::Tangent J = G::Tangent::Zero();  // the step is in the frame of T
  J.template head<G::kDim>() = 2 * T.matrix().transpose() * T.translation() / distance;
  QuadraticModel<G> expected, model;
  expected.A = J * J.transpose();
  expected.b = J * r;
  expected.cost = r * r;
  ASSERT_TRUE(LinearizeFactor(factor, false, T, &model));
  EXPECT_TRUE(IsSameModel(model, expected, 1e-13));
}

template <typename G>
class BadCost final : public ceres::CostFunction {
 public:
  BadCost(int blocks, bool fails, double value) : fails_(fails), value_(value) {
    set_num_residuals(2);
    mutable_parameter_block_sizes()->assign(blocks, G::kParams);
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    residuals[0] = 1;
    residuals[1] = value_;
    for (std::size_t b = 0; jacobians != nullptr && b < parameter_block_sizes().size(); ++b) {
      if (jacobians[b] != nullptr) std::fill_n(jacobians[b], 2 * G::kParams, value_);
    }
    return !fails_;
  }

 private:
  const bool fails_;
  const double value_;
};

TYPED_TEST(FactorTermTest, AFailedCustomCostIsReported) {
  using G = TypeParam;
  for (const bool unary : {false, true}) {
    for (const bool fails : {false, true}) {
      const double value = fails ? 1 : std::numeric_limits<double>::quiet_NaN();
      const BadCost<G> cost(unary ? 1 : 2, fails, value);
      FactorTerm<G> factor;
      factor.custom = &cost;
      QuadraticModel<G> model;
      EXPECT_TRUE(std::isnan(FactorCost(factor, unary, G())));
      EXPECT_FALSE(LinearizeFactor(factor, unary, G(), &model));
      EXPECT_EQ(FactorChange(factor, unary, G(), G()), 0);
    }
  }
}

}  // namespace
}  // namespace ceres_costs
