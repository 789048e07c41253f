#include "hpgo/evaluate/kitti_segments.h"

#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// Straight on, 1 m a pose; the estimate is `scale` times as long.
std::vector<SE2> Straight(int count, double scale) {
  std::vector<SE2> poses;
  for (int k = 0; k < count; ++k) poses.emplace_back(scale * k, 0, 0);
  return poses;
}

TEST(KittiSegmentsTest, ScaleDriftOnAStraight) {
  const auto errors = EvaluateKittiSegments(Straight(1000, 1.02), Straight(1000, 1.0));
  ASSERT_TRUE(errors.ok());
  // A segment of length L ends at the first pose farther than L: after L + 1 steps of 1 m. Of each
  // length, the starts are 0, 10, ... up to 998 - L.
  double ratio = 0;
  int segments = 0;
  for (int length = 100; length <= 800; length += 100) {
    const int starts = (998 - length) / 10 + 1;
    ratio += starts * 0.02 * (length + 1) / length;
    segments += starts;
  }
  EXPECT_EQ(errors->segments, segments);
  EXPECT_NEAR(errors->translation_ratio, ratio / segments, 1e-12);
  EXPECT_EQ(errors->rotation_rad_per_m, 0);
}

TEST(KittiSegmentsTest, HeadingDriftIn3d) {
  constexpr double kDrift = 1e-3;  // rad a metre
  std::vector<SE3> truth, estimate;
  SE3 pose;
  for (int k = 0; k < 500; ++k) {
    truth.emplace_back(Eigen::Vector3d(k, 0, 0), Eigen::Quaterniond::Identity());
    estimate.push_back(pose);
    SE3::Tangent step = SE3::Tangent::Zero();
    step(0) = 1;
    step(5) = kDrift;
    pose = pose.Retract(step);
  }
  KittiSegmentOptions options;
  options.lengths = {100};
  const auto errors = EvaluateKittiSegments(estimate, truth, options);
  ASSERT_TRUE(errors.ok());
  EXPECT_EQ(errors->segments, 40);
  EXPECT_NEAR(errors->rotation_rad_per_m, kDrift * 101 / 100, 1e-9);
}

TEST(KittiSegmentsTest, AShortPathHasNoSegment) {
  const auto errors = EvaluateKittiSegments(Straight(101, 1.5), Straight(101, 1.0));
  ASSERT_TRUE(errors.ok());
  EXPECT_EQ(errors->segments, 0) << "100 m do not exceed 100 m";
  EXPECT_EQ(errors->translation_ratio, 0);
}

TEST(KittiSegmentsTest, NamesWhatIsWrong) {
  const auto straight = Straight(3, 1.0);
  EXPECT_EQ(EvaluateKittiSegments(straight, Straight(2, 1.0)).status().ToString(),
            "invalid argument: 3 poses to align with 2");
  KittiSegmentOptions options;
  options.step = 0;
  EXPECT_EQ(EvaluateKittiSegments(straight, straight, options).status().ToString(),
            "invalid argument: segment step below 1");
  options.step = 1;
  options.lengths = {NAN};
  EXPECT_EQ(EvaluateKittiSegments(straight, straight, options).status().ToString(),
            "invalid argument: segment length not above 0");
}

}  // namespace
}  // namespace hpgo
