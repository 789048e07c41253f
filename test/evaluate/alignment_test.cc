#include "hpgo/evaluate/alignment.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"
#include "test/evaluate/random_poses.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
class AlignmentTest : public ::testing::Test {
 protected:
  // The length of the step from the true transform to the one found.
  double Distance(const G& truth, const Result<G>& found) {
    return found.ok() ? truth.LocalCoordinates(*found).norm() : NAN;
  }
  std::mt19937_64 rng_{7};
};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(AlignmentTest, Groups, );

TYPED_TEST(AlignmentTest, RecoversAKnownTransform) {
  for (int count : {1, 2, 3, 4, 100}) {
    const TypeParam truth = RandomPose<TypeParam>(&this->rng_);
    const auto estimate = RandomPoses<TypeParam>(&this->rng_, count);
    const auto reference = Moved(truth, estimate);
    EXPECT_LT(this->Distance(truth, Align(estimate, reference, AlignmentMode::kRigid)), 1e-10)
        << count << " poses";
    EXPECT_LT(this->Distance(truth, Align(estimate, reference, AlignmentMode::kFirstPose)), 1e-10);
    EXPECT_EQ(this->Distance(TypeParam(), Align(estimate, reference, AlignmentMode::kIdentity)), 0);
  }
}

TYPED_TEST(AlignmentTest, OrientationsDecideWhatAStraightLineLeavesOpen) {
  const TypeParam truth = RandomPose<TypeParam>(&this->rng_);
  auto estimate = RandomPoses<TypeParam>(&this->rng_, 50);
  for (int k = 0; k < 50; ++k) estimate[k].translation() = (1 + k) * TypeParam::Vector::Ones();
  const auto reference = Moved(truth, estimate);
  EXPECT_LT(this->Distance(truth, Align(estimate, reference, AlignmentMode::kRigid)), 1e-9);
}

TYPED_TEST(AlignmentTest, OrientationsDecideWhereTheRobotStandsStill) {
  const TypeParam truth = RandomPose<TypeParam>(&this->rng_);
  auto estimate = RandomPoses<TypeParam>(&this->rng_, 50);
  for (auto& pose : estimate) pose.translation() = 0.1 * TypeParam::Vector::Ones();
  const auto reference = Moved(truth, estimate);
  EXPECT_LT(this->Distance(truth, Align(estimate, reference, AlignmentMode::kRigid)), 1e-9);
}

TYPED_TEST(AlignmentTest, IsTheLeastSquaresOptimum) {
  const auto estimate = RandomPoses<TypeParam>(&this->rng_, 30);
  const auto reference = RandomPoses<TypeParam>(&this->rng_, 30);
  const auto best = Align(estimate, reference, AlignmentMode::kRigid);
  ASSERT_TRUE(best.ok()) << best.status().ToString();
  const auto cost = [&](const TypeParam& T) {
    double sum = 0;
    for (int k = 0; k < 30; ++k) {
      sum +=
          (T * typename TypeParam::Vector(estimate[k].translation()) - reference[k].translation())
              .squaredNorm();
    }
    return sum;
  };
  for (int k = 0; k < TypeParam::kDof; ++k) {
    for (double step : {-1e-3, 1e-3}) {
      EXPECT_GT(cost(best->Retract(step * TypeParam::Tangent::Unit(k))), cost(*best));
    }
  }
}

TYPED_TEST(AlignmentTest, MirroredPointsGetAProperRotation) {
  const auto estimate = RandomPoses<TypeParam>(&this->rng_, 20);
  auto reference = estimate;
  for (auto& pose : reference) pose.translation()(0) *= -1;
  const auto found = Align(estimate, reference, AlignmentMode::kRigid);
  ASSERT_TRUE(found.ok());
  EXPECT_NEAR(found->matrix().determinant(), 1.0, 1e-12);
}

TYPED_TEST(AlignmentTest, NamesWhatIsWrong) {
  auto estimate = RandomPoses<TypeParam>(&this->rng_, 3);
  auto reference = RandomPoses<TypeParam>(&this->rng_, 2);
  const auto error = [&] {
    return Align(estimate, reference, AlignmentMode::kRigid).status().ToString();
  };
  EXPECT_EQ(error(), "invalid argument: 3 poses to align with 2");
  reference.push_back(TypeParam());
  reference[1].translation()(0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(error(), "invalid argument: reference pose 1 is not finite");
  estimate[0].translation()(1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(error(), "invalid argument: estimated pose 0 is not finite");
  estimate.clear();
  reference.clear();
  EXPECT_EQ(error(), "invalid argument: no poses to align");
}

}  // namespace
}  // namespace hpgo
