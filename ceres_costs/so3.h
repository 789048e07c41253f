// SO(3) on unit quaternions: exponential, logarithm and right Jacobians. Eigen only; every function
// works with ceres::Jet. Angles in radians.
#pragma once

#include <cmath>

#include "Eigen/Core"
#include "Eigen/Geometry"

namespace ceres_costs {

// Below this squared angle the coefficients of the Jacobians are series: their closed forms, and
// more so the derivatives of these by Jets, lose digits to cancellation.
inline constexpr double kSeriesLimitSq = 1e-2;

// The cross-product matrix: Skew(a) * b == a.cross(b).
template <typename Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 3> Skew(const Eigen::MatrixBase<Derived>& v) {
  using S = typename Derived::Scalar;
  Eigen::Matrix<S, 3, 3> m;
  m << S(0), -v(2), v(1), v(2), S(0), -v(0), -v(1), v(0), S(0);
  return m;
}

// The unit quaternion of the rotation vector `phi` (axis times angle).
template <typename Derived>
Eigen::Quaternion<typename Derived::Scalar> So3Exp(const Eigen::MatrixBase<Derived>& phi) {
  using S = typename Derived::Scalar;
  using std::cos;
  using std::sin;
  using std::sqrt;
  const S theta_sq = phi.squaredNorm();
  S w, k;  // q = (w, k * phi)
  if (theta_sq > S(1e-8)) {
    const S half = S(0.5) * sqrt(theta_sq);
    w = cos(half);
    k = S(0.5) * sin(half) / half;
  } else {
    w = S(1) - theta_sq * (S(0.125) - theta_sq / S(384.0));
    k = S(0.5) - theta_sq / S(48.0);
  }
  return Eigen::Quaternion<S>(w, k * phi(0), k * phi(1), k * phi(2));
}

// The rotation vector of a unit quaternion, of length at most pi.
template <typename Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 1> So3Log(const Eigen::QuaternionBase<Derived>& q) {
  using S = typename Derived::Scalar;
  using std::atan2;
  using std::sqrt;
  const S sign = q.w() < S(0) ? S(-1) : S(1);
  const S w = sign * q.w();
  const Eigen::Matrix<S, 3, 1> v = sign * q.vec();
  const S n_sq = v.squaredNorm();
  if (n_sq > S(1e-12)) {
    const S n = sqrt(n_sq);
    return (S(2) * atan2(n, w) / n) * v;
  }
  return (S(2) / w * (S(1) - n_sq / (S(3) * w * w))) * v;
}

// Right Jacobian: Exp(phi + d) ~ Exp(phi) Exp(Jr(phi) d).
template <typename Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 3> So3RightJacobian(
    const Eigen::MatrixBase<Derived>& phi) {
  using S = typename Derived::Scalar;
  using std::sin;
  using std::sqrt;
  const S theta_sq = phi.squaredNorm();
  const Eigen::Matrix<S, 3, 3> w = Skew(phi);
  S a, b;
  if (theta_sq > S(kSeriesLimitSq)) {
    const S theta = sqrt(theta_sq);
    const S s = sin(S(0.5) * theta);
    a = S(2) * s * s / theta_sq;  // 1 - cos(theta) would cancel
    b = (theta - sin(theta)) / (theta_sq * theta);
  } else {
    a = S(0.5) - theta_sq * (S(1.0 / 24) - theta_sq * (S(1.0 / 720) - theta_sq / S(40320)));
    b = S(1.0 / 6) - theta_sq * (S(1.0 / 120) - theta_sq * (S(1.0 / 5040) - theta_sq / S(362880)));
  }
  return Eigen::Matrix<S, 3, 3>::Identity() - a * w + b * w * w;
}

// c(theta^2) = (1 - theta/2 cot(theta/2)) / theta^2, the coefficient of the inverse Jacobians of
// all groups here.
template <typename S>
S InverseJacobianCoefficient(const S& theta_sq) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  if (theta_sq > S(kSeriesLimitSq)) {
    const S half = S(0.5) * sqrt(theta_sq);
    return (S(1) - half * cos(half) / sin(half)) / theta_sq;
  }
  return S(1.0 / 12) +
         theta_sq * (S(1.0 / 720) + theta_sq * (S(1.0 / 30240) + theta_sq / S(1209600)));
}

// The inverse of So3RightJacobian; singular at |phi| = 2 pi only.
template <typename Derived>
Eigen::Matrix<typename Derived::Scalar, 3, 3> So3RightJacobianInverse(
    const Eigen::MatrixBase<Derived>& phi) {
  using S = typename Derived::Scalar;
  const S c = InverseJacobianCoefficient(S(phi.squaredNorm()));
  const Eigen::Matrix<S, 3, 3> w = Skew(phi);
  return Eigen::Matrix<S, 3, 3>::Identity() + S(0.5) * w + c * w * w;
}

}  // namespace ceres_costs
