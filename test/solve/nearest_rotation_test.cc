// The rotation that is nearest to a matrix, about any axis and about z alone.

#include <random>

#include "Eigen/Geometry"
#include "gtest/gtest.h"
#include "hpgo/solve/initial_guess_rotation.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
typename G::RotationMatrix NearestRotation(const typename G::RotationMatrix& m,
                                           const typename G::RotationMatrix& fallback) {
  G pose = G().Retract(G::Tangent::Ones());
  const typename G::Vector t = pose.translation();
  SetNearestRotation(m, fallback, &pose);
  EXPECT_EQ(pose.translation(), t);
  return pose.matrix();
}

TEST(NearestRotationTest, IsProperAndLeavesRotationsAlone) {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), zero = Eigen::Matrix3d::Zero();
  EXPECT_LT((NearestRotation<SE3>(0.3 * R, I) - R).norm(), 1e-12);
  Eigen::Matrix3d mirrored = R;
  mirrored.col(2) *= -0.1;
  EXPECT_LT((NearestRotation<SE3>(mirrored, I) - R).norm(), 1e-12);
  EXPECT_LT((NearestRotation<SE3>(zero, R) - R).norm(), 1e-12);
  EXPECT_LT((NearestRotation<SE2>(Eigen::Vector2d(2, 3).asDiagonal(), Eigen::Matrix2d::Zero()) -
             Eigen::Matrix2d::Identity())
                .norm(),
            1e-12);
}

// What is nearest about z, not the part about z of what is nearest.
TEST(NearestRotationTest, AboutZAlone) {
  const Eigen::Matrix3d zero = Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d R = YawPose(0, 0, 0, 2).matrix();
  EXPECT_LT((NearestRotation<YawPose>(0.3 * R, zero) - R).norm(), 1e-12);
  EXPECT_LT((NearestRotation<YawPose>(zero, R) - R).norm(), 1e-12);
  std::mt19937_64 rng(3);
  for (int k = 0; k < 20; ++k) {
    const Eigen::Matrix3d m = RandomPose<SE3>(&rng, 1, 2).matrix() + 0.1 * Eigen::Matrix3d::Ones();
    const Eigen::Matrix3d nearest = NearestRotation<YawPose>(m, zero);
    for (const double turn : {-0.01, 0.01}) {
      EXPECT_GT((YawPose(0, 0, 0, turn).matrix() * nearest - m).norm(), (nearest - m).norm());
    }
  }
}

}  // namespace
}  // namespace hpgo
