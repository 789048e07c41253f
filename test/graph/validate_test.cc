#include "hpgo/graph/validate.h"

#include <cmath>
#include <limits>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

SE3 WithQuaternion(double x, double y, double z, double w) {
  const double numbers[7] = {1, 2, 3, x, y, z, w};
  return SE3(numbers);
}

TEST(ValidateTest, Poses) {
  EXPECT_EQ(PoseProblem(SE2(1, 2, 3)), "");
  EXPECT_EQ(PoseProblem(SE2(1, std::nan(""), 3)), "is not finite");
  EXPECT_EQ(PoseProblem(SE2(kInf, 2, 3)), "is not finite");
  EXPECT_EQ(PoseProblem(SE2(1e51, 2, 3)), "is too large");
  EXPECT_EQ(PoseProblem(SE3()), "");
  EXPECT_EQ(PoseProblem(WithQuaternion(0, 0, 0, std::nan(""))), "is not finite");
  EXPECT_EQ(PoseProblem(WithQuaternion(0, 0, 0, 0)), "has a zero quaternion");
  EXPECT_EQ(PoseProblem(WithQuaternion(0, 1e-310, 0, 0)), "has a zero quaternion");
  SE3 far;
  far.translation()(2) = -1e300;
  EXPECT_EQ(PoseProblem(far), "is too large");
}

// Of any other length a quaternion says where it points.
TEST(ValidateTest, LongAndShortQuaternionsAreNormalized) {
  for (const double length : {1e-8, 1e-3, 1e100, 1e160, 1e308}) {
    const SE3 pose = WithQuaternion(0.6 * length, 0, 0, 0.8 * length);
    EXPECT_EQ(PoseProblem(pose), "") << length;
    EXPECT_NEAR(pose.Normalized().rotation().x(), 0.6, 1e-15) << length;
    EXPECT_NEAR(pose.Normalized().rotation().w(), 0.8, 1e-15) << length;
  }
}

TEST(ValidateTest, LargeAnglesAreWrapped) {
  for (const double angle : {4., -1e3, 1e15, 1e49}) {
    const double wrapped = SE2(0, 0, angle).Normalized().angle();
    EXPECT_LE(std::abs(wrapped), 3.1415927) << angle;
    EXPECT_NEAR(std::sin(wrapped), std::sin(std::remainder(angle, 2 * M_PI)), 1e-12) << angle;
  }
}

TEST(ValidateTest, Information) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  EXPECT_EQ(InformationProblem<3>(m), "");
  m(0, 1) = 0.5;
  EXPECT_EQ(InformationProblem<3>(m), "information is not symmetric");
  m(1, 0) = 0.5;
  EXPECT_EQ(InformationProblem<3>(m), "");
  m(0, 0) = 0;
  EXPECT_EQ(InformationProblem<3>(m),
            "information is not positive semi-definite, smallest eigenvalue -0.207107");
  m(0, 0) = 1e60;
  EXPECT_EQ(InformationProblem<3>(m), "information is too large");
  m(0, 0) = kInf;
  EXPECT_EQ(InformationProblem<3>(m), "information is not finite");
}

}  // namespace
}  // namespace hpgo
