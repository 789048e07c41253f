#include "ceres_costs/relative_pose_error.h"

namespace ceres_costs {

SE3::Matrix DeviationJacobian(ErrorConvention convention, const SE3& D, const SE3::Tangent& e) {
  if (convention == ErrorConvention::kTwist) return Se3RightJacobianInverse(e);
  SE3::Matrix J = SE3::Matrix::Zero();
  J.topLeftCorner<3, 3>() = D.matrix();
  if (convention == ErrorConvention::kSplitLog) {
    J.bottomRightCorner<3, 3>() = So3RightJacobianInverse(e.tail<3>());
  } else {
    const double sign = D.rotation().w() < 0 ? -1 : 1;
    J.bottomRightCorner<3, 3>() = 0.5 * Skew(e.tail<3>());
    J.bottomRightCorner<3, 3>().diagonal().array() += 0.5 * sign * D.rotation().w();
  }
  return J;
}

SE2::Matrix DeviationJacobian(ErrorConvention convention, const SE2& D, const SE2::Tangent& e) {
  if (convention == ErrorConvention::kTwist) return Se2RightJacobianInverse(e);
  SE2::Matrix J = SE2::Matrix::Identity();
  J.topLeftCorner<2, 2>() = D.matrix();
  return J;
}

YawPose::Matrix DeviationJacobian(ErrorConvention convention, const YawPose& D,
                                  const YawPose::Tangent& e) {
  if (convention == ErrorConvention::kTwist) return YawPoseRightJacobianInverse(e);
  YawPose::Matrix J = YawPose::Matrix::Identity();
  J.topLeftCorner<3, 3>() = D.matrix();
  return J;
}

}  // namespace ceres_costs
