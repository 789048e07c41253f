// Rotation matrices as the initial guesses need them, for all groups.
#pragma once

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace hpgo {

// Gives the pose the rotation of its group that is nearest to `m` in the Frobenius norm; `fallback`
// if m is zero.
void SetNearestRotation(const Eigen::Matrix2d& m, const Eigen::Matrix2d& fallback,
                        ceres_costs::SE2* pose);
void SetNearestRotation(const Eigen::Matrix3d& m, const Eigen::Matrix3d& fallback,
                        ceres_costs::SE3* pose);
void SetNearestRotation(const Eigen::Matrix3d& m, const Eigen::Matrix3d& fallback,
                        ceres_costs::YawPose* pose);

}  // namespace hpgo
