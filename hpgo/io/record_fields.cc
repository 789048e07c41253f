#include "hpgo/io/record_fields.h"

#include <algorithm>
#include <cmath>

#include "hpgo/graph/validate.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// The rows and columns from `first` on, a packed upper triangle of size `count`.
template <typename Matrix>
void FillBlock(const double* numbers, int count, Matrix* m) {
  for (int r = 0; r < count; ++r) {
    for (int c = r; c < count; ++c) (*m)(r, c) = (*m)(c, r) = *numbers++;
  }
}

}  // namespace

QuaternionState NormalizeQuaternion(double* q, double* norm) {
  const double squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  if (std::abs(squared - 1) <= 1e-12) {
    *norm = 1;
    return QuaternionState::kUnit;
  }
  // Scaled first, so that squares of very large numbers stay finite.
  const double scale = std::max({std::abs(q[0]), std::abs(q[1]), std::abs(q[2]), std::abs(q[3])});
  if (scale < kZeroQuaternion) {
    *norm = scale;
    return QuaternionState::kZero;
  }
  Eigen::Map<Eigen::Vector4d> v(q);
  v /= scale;
  *norm = scale * v.norm();
  v.normalize();
  return std::abs(*norm - 1) > kQuaternionTolerance ? QuaternionState::kNormalized
                                                    : QuaternionState::kUnit;
}

QuaternionState ToPose(const double* numbers, int count, SE2* pose, double* norm) {
  *pose = SE2(numbers[0], numbers[1], count > 2 ? numbers[2] : 0);
  *norm = 1;
  return QuaternionState::kUnit;
}

QuaternionState ToPose(const double* numbers, int count, SE3* pose, double* norm) {
  *pose = SE3();
  *norm = 1;
  std::copy(numbers, numbers + 3, pose->data());
  if (count == 7) {
    std::copy(numbers + 3, numbers + 7, pose->data() + 3);
    return NormalizeQuaternion(pose->data() + 3, norm);
  }
  if (count == 6) {
    pose->rotation() = Eigen::AngleAxisd(numbers[5], Eigen::Vector3d::UnitZ()) *
                       Eigen::AngleAxisd(numbers[4], Eigen::Vector3d::UnitY()) *
                       Eigen::AngleAxisd(numbers[3], Eigen::Vector3d::UnitX());
  }
  return QuaternionState::kUnit;
}

void ToInformation(const double* numbers, const RecordTag& tag, Edge2Order order,
                   SE2::Matrix* information) {
  information->setZero();
  if (tag.information == 3) {
    FillBlock(numbers, 2, information);
  } else if (tag.form == InformationForm::kRoot) {
    SE2::Matrix R = SE2::Matrix::Zero();
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) R(r, c) = *numbers++;
    }
    *information = R.transpose() * R;
  } else if (tag.form == InformationForm::kToro && order == Edge2Order::kToro) {
    const double row_major[6] = {numbers[0], numbers[1], numbers[4],
                                 numbers[2], numbers[5], numbers[3]};
    FillBlock(row_major, 3, information);
  } else {
    FillBlock(numbers, 3, information);
  }
}

void ToInformation(const double* numbers, const RecordTag& tag, Edge2Order,
                   SE3::Matrix* information) {
  information->setZero();
  if (tag.information == 6) {
    FillBlock(numbers, 3, information);
    return;
  }
  FillBlock(numbers, 6, information);
  if (tag.pose == 6) {
    information->bottomRows<3>() *= 2;
    information->rightCols<3>() *= 2;
  }
}

}  // namespace hpgo
