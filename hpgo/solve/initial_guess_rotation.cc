#include "hpgo/solve/initial_guess_rotation.h"

#include <cmath>

#include "Eigen/LU"
#include "Eigen/SVD"

namespace hpgo {
namespace {

template <int d>
Eigen::Matrix<double, d, d> NearestRotation(const Eigen::Matrix<double, d, d>& m,
                                            const Eigen::Matrix<double, d, d>& fallback) {
  const Eigen::JacobiSVD<Eigen::Matrix<double, d, d>> svd(
      m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()(0) > 1e-12)) return fallback;
  Eigen::Matrix<double, d, 1> signs = Eigen::Matrix<double, d, 1>::Ones();
  if ((svd.matrixU() * svd.matrixV().transpose()).determinant() < 0) signs(d - 1) = -1;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

double Angle(const Eigen::Matrix2d& rotation) { return std::atan2(rotation(1, 0), rotation(0, 0)); }

}  // namespace

void SetNearestRotation(const Eigen::Matrix2d& m, const Eigen::Matrix2d& fallback,
                        ceres_costs::SE2* pose) {
  const auto t = pose->translation();
  *pose = ceres_costs::SE2(t(0), t(1), Angle(NearestRotation<2>(m, fallback)));
}
void SetNearestRotation(const Eigen::Matrix3d& m, const Eigen::Matrix3d& fallback,
                        ceres_costs::SE3* pose) {
  pose->rotation() = Eigen::Quaterniond(NearestRotation<3>(m, fallback));
}
void SetNearestRotation(const Eigen::Matrix3d& m, const Eigen::Matrix3d& fallback,
                        ceres_costs::YawPose* pose) {
  const auto t = pose->translation();
  // Of a rotation about z only the upper left block counts.
  const double yaw =
      Angle(NearestRotation<2>(m.topLeftCorner<2, 2>(), fallback.topLeftCorner<2, 2>()));
  *pose = ceres_costs::YawPose(t(0), t(1), t(2), yaw);
}

}  // namespace hpgo
