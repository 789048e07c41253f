// The right Jacobians of the groups, by the closed form x / (1 - exp(-x)) of ad(xi).
#include <cmath>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace ceres_costs {
namespace {

// dc/d(theta^2) of InverseJacobianCoefficient.
double InverseJacobianCoefficientDerivative(double theta_sq, double c) {
  if (theta_sq <= kSeriesLimitSq) {
    return 1.0 / 720 + theta_sq * (1.0 / 15120 + theta_sq * (1.0 / 403200 + theta_sq / 11975040));
  }
  const double theta = std::sqrt(theta_sq), half = 0.5 * theta, s = std::sin(half);
  return (half / (s * s) - std::cos(half) / s) / (4 * theta_sq * theta) - c / theta_sq;
}

}  // namespace

SE2::Matrix Se2RightJacobianInverse(const SE2::Tangent& xi) {
  const double w = xi(2), c = InverseJacobianCoefficient(w * w);
  const double a = 1 - c * w * w;  // w/2 cot(w/2)
  SE2::Matrix J;
  J << a, -0.5 * w, c * w * xi(0) + 0.5 * xi(1),  //
      0.5 * w, a, c * w * xi(1) - 0.5 * xi(0),    //
      0, 0, 1;
  return J;
}

YawPose::Matrix YawPoseRightJacobianInverse(const YawPose::Tangent& xi) {
  const SE2::Matrix plane = Se2RightJacobianInverse(SE2::Tangent(xi(0), xi(1), xi(3)));
  YawPose::Matrix J = YawPose::Matrix::Identity();
  J.topLeftCorner<2, 2>() = plane.topLeftCorner<2, 2>();
  J.topRightCorner<2, 1>() = plane.topRightCorner<2, 1>();
  return J;
}

// [Jr^-1(phi), D; 0, Jr^-1(phi)] with D the derivative of Jr^-1(phi) of SO(3) along rho: ad(xi) of
// SE(3) is that of SO(3) over the dual numbers, phi + eps rho.
SE3::Matrix Se3RightJacobianInverse(const SE3::Tangent& xi) {
  const Eigen::Vector3d rho = xi.head<3>(), phi = xi.tail<3>();
  const double theta_sq = phi.squaredNorm(), c = InverseJacobianCoefficient(theta_sq);
  const double dc = 2 * phi.dot(rho) * InverseJacobianCoefficientDerivative(theta_sq, c);
  const Eigen::Matrix3d P = Skew(phi), R = Skew(rho);
  const Eigen::Matrix3d PP = P * P, PR = P * R;
  SE3::Matrix J;
  J.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() + 0.5 * P + c * PP;
  J.topRightCorner<3, 3>() = 0.5 * R + c * (PR + PR.transpose()) + dc * PP;  // (PR)' = RP
  J.bottomLeftCorner<3, 3>().setZero();
  J.bottomRightCorner<3, 3>() = J.topLeftCorner<3, 3>();
  return J;
}

}  // namespace ceres_costs
