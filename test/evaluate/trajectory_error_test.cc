#include "hpgo/evaluate/trajectory_error.h"

#include <cmath>

#include "gtest/gtest.h"
#include "hpgo/evaluate/ground_plane.h"
#include "test/evaluate/random_poses.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

TEST(StatisticsTest, KnownValues) {
  const ErrorStatistics s = Summarize({3, 0, 4, 1});
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(26 / 4.0));
  EXPECT_DOUBLE_EQ(s.mean, 2);
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_EQ(s.max_index, 2);
  EXPECT_EQ(s.count, 4);
  EXPECT_EQ(Summarize({}).count, 0);
}

TEST(StatisticsTest, NaNPassesNoThreshold) {
  const ErrorStatistics s = Summarize({3, NAN, 4});
  EXPECT_FALSE(s.rmse < 1e9);
  EXPECT_FALSE(s.mean < 1e9);
  EXPECT_FALSE(s.max < 1e9);
  EXPECT_EQ(s.max_index, 1);
}

TEST(AbsoluteTrajectoryErrorTest, ASquareWithOneCornerOff) {
  const std::vector<SE2> reference = {SE2(0, 0, 0), SE2(4, 0, 1), SE2(4, 4, 2), SE2(0, 4, 3)};
  std::vector<SE2> estimate = reference;
  estimate[2] = SE2(4, 7, 2.5);
  const auto error = AbsoluteTrajectoryError(estimate, reference, AlignmentMode::kIdentity);
  ASSERT_TRUE(error.ok());
  EXPECT_DOUBLE_EQ(error->translation.rmse, 1.5);
  EXPECT_DOUBLE_EQ(error->translation.mean, 0.75);
  EXPECT_DOUBLE_EQ(error->translation.max, 3);
  EXPECT_EQ(error->translation.max_index, 2);
  EXPECT_NEAR(error->rotation.max, 0.5, 1e-15);
  // A rigid fit leaves no more than no fit.
  const auto aligned = AbsoluteTrajectoryError(estimate, reference);
  ASSERT_TRUE(aligned.ok());
  EXPECT_LT(aligned->translation.rmse, 1.5);
  EXPECT_GT(aligned->translation.rmse, 0.5);
}

TEST(AbsoluteTrajectoryErrorTest, VanishesUnderAnyFrame) {
  std::mt19937_64 rng(5);
  const auto reference = RandomPoses<SE3>(&rng, 40);
  const auto estimate = Moved(RandomPose<SE3>(&rng), reference);
  const auto error = AbsoluteTrajectoryError(estimate, reference);
  ASSERT_TRUE(error.ok());
  EXPECT_LT(error->translation.max, 1e-12);
  EXPECT_LT(error->rotation.max, 1e-12);
}

TEST(RelativeTrajectoryErrorTest, ConstantDriftAStep) {
  std::vector<SE3> reference, estimate;
  const Eigen::Quaterniond level = Eigen::Quaterniond::Identity();
  for (int k = 0; k < 50; ++k) {
    reference.emplace_back(Eigen::Vector3d(k, 0, 0), level);
    estimate.emplace_back(Eigen::Vector3d(1.01 * k, 0, 0), level);
  }
  for (int delta : {1, 7}) {
    const auto error = RelativeTrajectoryError(estimate, reference, delta);
    ASSERT_TRUE(error.ok());
    EXPECT_EQ(error->translation.count, 50 - delta);
    EXPECT_NEAR(error->translation.rmse, 0.01 * delta, 1e-12);
    EXPECT_NEAR(error->rotation.max, 0, 1e-12);
  }
}

TEST(RelativeTrajectoryErrorTest, NeedsMotions) {
  const std::vector<SE2> poses(3);
  EXPECT_EQ(RelativeTrajectoryError(poses, poses, 3).status().ToString(),
            "invalid argument: no motions over 3 poses in a trajectory of 3");
  EXPECT_EQ(RelativeTrajectoryError(poses, poses, 0).status().ToString(),
            "invalid argument: no motions over 0 poses in a trajectory of 3");
}

// Driving a planar path, seen by a camera that looks ahead: composing the motions on the plane and
// projecting the camera's poses give the same.
TEST(GroundPlaneTest, CameraFrameKeepsPositionsAndHeadings) {
  const SE2 planar_motion(1.0, 0.2, 0.3);
  // The same motion in camera axes: forward z, left -x, a left turn about -y.
  const SE3 camera_motion(Eigen::Vector3d(-0.2, 0, 1.0),
                          Eigen::Quaterniond(Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY())));
  SE2 planar;
  SE3 camera;
  for (int k = 0; k < 20; ++k) {
    planar = planar * planar_motion;
    camera = camera * camera_motion;
    EXPECT_LT(planar.LocalCoordinates(ProjectToPlane(camera, GroundPlane::kXz)).norm(), 1e-13);
  }
}

TEST(GroundPlaneTest, UprightFrameTakesTheYaw) {
  const SE3 pose(Eigen::Vector3d(1, 2, 3),
                 Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ())));
  const SE2 planar = ProjectToPlane(pose, GroundPlane::kXy);
  EXPECT_LT(SE2(1, 2, 0.7).LocalCoordinates(planar).norm(), 1e-15);
}

}  // namespace
}  // namespace hpgo
