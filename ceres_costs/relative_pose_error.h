// The error of a relative pose measurement Z of T_i_j = X_i^-1 X_j, and its Jacobians.
// Eigen only. Shared by the Ceres costs, the coarse edges and the block solver.
#pragma once

#include <cstdint>

#include "ceres_costs/packed_symmetric.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace ceres_costs {

// How the deviation D = Z^-1 X_i^-1 X_j becomes a vector e, translation first.
enum class ErrorConvention : std::uint8_t {
  kG2o,       // translation, vector part of the quaternion (w >= 0), or the one angle
  kTwist,     // the group logarithm, the paper's twist (eq. 3)
  kSplitLog,  // translation, rotation vector. Equals kG2o where the angle is one
};

// A measurement Z of T_i_j and the information (inverse covariance) of its error.
template <typename G>
struct RelativePoseTerm {
  G measurement;
  PackedSymmetric<G::kDof> information;

  // For archives.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.measurement, self.information);
  }
};

// e(D); see ErrorConvention.
template <typename S>
Eigen::Matrix<S, 6, 1> DeviationError(ErrorConvention convention, const SE3T<S>& D) {
  if (convention == ErrorConvention::kTwist) return D.Log();
  Eigen::Matrix<S, 6, 1> e;
  e.template head<3>() = D.translation();
  if (convention == ErrorConvention::kSplitLog) {
    e.template tail<3>() = So3Log(D.rotation());
  } else {
    const S sign = D.rotation().w() < S(0) ? S(-1) : S(1);
    e.template tail<3>() = sign * D.rotation().vec();
  }
  return e;
}
template <typename S>
Eigen::Matrix<S, 3, 1> DeviationError(ErrorConvention convention, const SE2T<S>& D) {
  if (convention == ErrorConvention::kTwist) return D.Log();
  return Eigen::Matrix<S, 3, 1>(D.data()[0], D.data()[1], D.data()[2]);
}
template <typename S>
Eigen::Matrix<S, 4, 1> DeviationError(ErrorConvention convention, const YawPoseT<S>& D) {
  if (convention == ErrorConvention::kTwist) return D.Log();
  return Eigen::Matrix<S, 4, 1>(D.data());
}

// The Jacobian of e(D) under a right perturbation of D. `e` is DeviationError(convention, D).
SE3::Matrix DeviationJacobian(ErrorConvention convention, const SE3& D, const SE3::Tangent& e);
SE2::Matrix DeviationJacobian(ErrorConvention convention, const SE2& D, const SE2::Tangent& e);
YawPose::Matrix DeviationJacobian(ErrorConvention convention, const YawPose& D,
                                  const YawPose::Tangent& e);

// The error at the relative pose T_i_j and, unless null, its Jacobian under a right perturbation of
// X_j. That of X_i follows: J_i = -J_j Ad(T_i_j^-1).
template <typename G>
typename G::Tangent RelativePoseError(ErrorConvention convention, const G& Z, const G& T_i_j,
                                      typename G::Matrix* J_j) {
  const G D = Z.Between(T_i_j);
  const typename G::Tangent e = DeviationError(convention, D);
  if (J_j != nullptr) *J_j = DeviationJacobian(convention, D, e);
  return e;
}

}  // namespace ceres_costs
