// Factors with a cost of the caller's.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "ceres/autodiff_cost_function.h"
#include "ceres_costs/factor_term.h"
#include "ceres_costs/prior_cost.h"
#include "ceres_costs/relative_pose_cost.h"
#include "test/ceres_costs/factor_samples.h"

namespace ceres_costs {
namespace {

template <typename G>
class FactorTermCustomTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FactorTermCustomTest, Groups);

// The built-in costs through Jets, as if they were somebody else's.
TYPED_TEST(FactorTermCustomTest, ACustomCostGivesTheSameAsItsTerm) {
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

TYPED_TEST(FactorTermCustomTest, ACustomCostMayHaveFewerResiduals) {
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

TYPED_TEST(FactorTermCustomTest, AFailedCustomCostIsReported) {
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
