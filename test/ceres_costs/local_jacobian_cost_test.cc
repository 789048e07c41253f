#include "ceres_costs/local_jacobian_cost.h"

#include "ceres/autodiff_cost_function.h"
#include "test/ceres_costs/cost_checks.h"

namespace ceres_costs {
namespace {

// A foreign cost over two poses, of another number of residuals than either group has dimensions:
// the distance of their origins, once squared.
struct DistanceResidual {
  template <typename S>
  bool operator()(const S* a, const S* b, S* residuals) const {
    const S dx = a[0] - b[0], dy = a[1] - b[1];
    residuals[0] = dx * dx + dy * dy - S(4);
    residuals[1] = dx * a[2];
    return true;
  }
};

template <typename G>
std::unique_ptr<ceres::CostFunction> MakeDistanceCost() {
  return std::make_unique<ceres::AutoDiffCostFunction<DistanceResidual, 2, G::kParams, G::kParams>>(
      new DistanceResidual);
}

class FailingCost final : public ceres::SizedCostFunction<1, 7> {
 public:
  bool Evaluate(double const* const*, double*, double**) const override { return false; }
};

template <typename G>
class LocalJacobianCostTest : public testing::Test {};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(LocalJacobianCostTest, Groups);

TYPED_TEST(LocalJacobianCostTest, TurnsJacobiansIntoLocalOnes) {
  using G = TypeParam;
  std::mt19937 rng(1);
  const auto foreign = MakeDistanceCost<G>();
  const LocalJacobianCost<G> borrowing(foreign.get());
  const LocalJacobianCost<G> owning(MakeDistanceCost<G>());
  for (int k = 0; k < 10; ++k) {
    const std::vector<G> poses = {RandomPose<G>(&rng, 5), RandomPose<G>(&rng, 5)};
    ExpectLocalOf(*foreign, borrowing, poses, 1e-13);
    ExpectLocalOf(*foreign, owning, poses, 1e-13);
    ExpectNumericJacobians(owning, poses, 1e-7);
  }
}

TYPED_TEST(LocalJacobianCostTest, HasTheSizesOfTheOther) {
  using G = TypeParam;
  const LocalJacobianCost<G> cost(MakeDistanceCost<G>());
  EXPECT_EQ(cost.num_residuals(), 2);
  EXPECT_EQ(cost.parameter_block_sizes(), std::vector<int32_t>(2, G::kParams));
}

TYPED_TEST(LocalJacobianCostTest, NullJacobiansAreLeftOut) {
  using G = TypeParam;
  std::mt19937 rng(2);
  const LocalJacobianCost<G> cost(MakeDistanceCost<G>());
  const std::vector<G> poses = {RandomPose<G>(&rng, 5), RandomPose<G>(&rng, 5)};
  const Evaluation<G> full = Evaluate<G>(cost, poses);
  Evaluation<G> partial = full;
  partial.jacobians[1].setZero();
  const double* parameters[] = {poses[0].data(), poses[1].data()};
  double* jacobians[] = {nullptr, partial.jacobians[1].data()};
  ASSERT_TRUE(cost.Evaluate(parameters, partial.residuals.data(), jacobians));
  EXPECT_EQ(partial.jacobians[1], full.jacobians[1]);
  EXPECT_EQ(Residuals<G>(cost, poses), full.residuals);
}

TEST(LocalJacobianCostFailureTest, FailsWhereTheOtherFails) {
  const LocalJacobianCost<SE3> cost(std::make_unique<FailingCost>());
  const SE3 pose;
  const double* parameters[] = {pose.data()};
  double residual;
  EXPECT_FALSE(cost.Evaluate(parameters, &residual, nullptr));
}

TEST(LocalJacobianCostFailureTest, KnowsWhatIsNotOverPoses) {
  EXPECT_TRUE(LocalJacobianCost<SE3>::IsOverPoses(*MakeDistanceCost<SE3>()));
  EXPECT_FALSE(LocalJacobianCost<SE2>::IsOverPoses(*MakeDistanceCost<SE3>()));
  EXPECT_DEATH(LocalJacobianCost<SE2>(MakeDistanceCost<SE3>()),
               "every parameter block must be a pose of 3 numbers");
}

}  // namespace
}  // namespace ceres_costs
