#include "hpgo/solve/initial_guess_rotation.h"

#include <cmath>

#include "Eigen/LU"
#include "Eigen/SVD"

namespace hpgo {

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

void SetRotation(const Eigen::Matrix2d& rotation, ceres_costs::SE2* pose) {
  const auto t = pose->translation();
  *pose = ceres_costs::SE2(t(0), t(1), std::atan2(rotation(1, 0), rotation(0, 0)));
}
void SetRotation(const Eigen::Matrix3d& rotation, ceres_costs::SE3* pose) {
  pose->rotation() = Eigen::Quaterniond(rotation);
}

template Eigen::Matrix2d NearestRotation<2>(const Eigen::Matrix2d&, const Eigen::Matrix2d&);
template Eigen::Matrix3d NearestRotation<3>(const Eigen::Matrix3d&, const Eigen::Matrix3d&);

}  // namespace hpgo
