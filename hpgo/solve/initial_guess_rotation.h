// Rotation matrices as the initial guesses need them, for both groups.
#pragma once

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"

namespace hpgo {

// The rotation nearest to `m` in the Frobenius norm; `fallback` if m is zero.
template <int d>
Eigen::Matrix<double, d, d> NearestRotation(const Eigen::Matrix<double, d, d>& m,
                                            const Eigen::Matrix<double, d, d>& fallback);

void SetRotation(const Eigen::Matrix2d& rotation, ceres_costs::SE2* pose);
void SetRotation(const Eigen::Matrix3d& rotation, ceres_costs::SE3* pose);

}  // namespace hpgo
