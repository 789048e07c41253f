#include "hpgo/ceres/pose_codec.h"

#include <cmath>

#include "ceres_costs/manifolds.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace hpgo {
namespace {

using ceres_costs::NormalizeAngle;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

constexpr double kDegree = 3.14159265358979323846 / 180;

bool IsInverse(const PoseLayout& layout) {
  return layout.direction == PoseLayout::Direction::kNodeWorld;
}

double AngleUnit(const PoseLayout& layout) {
  return layout.angle == PoseLayout::AngleUnit::kDegrees ? kDegree : 1;
}

// Where the numbers x y z qx qy qz qw, x y theta, or x y z yaw, are.
int PlaceOf(const PoseLayout& layout, const SE3&, int k) {
  if (k < 3) return layout.translation_at + k;
  const bool w_first = layout.quaternion == PoseLayout::Quaternion::kWFirst;
  return layout.rotation_at + (w_first ? (k - 2) % 4 : k - 3);
}
template <typename G>
int PlaceOf(const PoseLayout& layout, const G&, int k) {
  return k < G::kDim ? layout.translation_at + k : layout.rotation_at;
}

SE3 FromStored(const PoseLayout&, const SE3&, const double* numbers) {
  return SE3(numbers).Normalized();
}
SE2 FromStored(const PoseLayout& layout, const SE2&, const double* numbers) {
  return SE2(numbers[0], numbers[1], NormalizeAngle(numbers[2] * AngleUnit(layout)));
}
YawPose FromStored(const PoseLayout& layout, const YawPose&, const double* numbers) {
  return YawPose(numbers[0], numbers[1], numbers[2],
                 NormalizeAngle(numbers[3] * AngleUnit(layout)));
}

// -1 where the stored quaternion is the other of the two that mean the same.
double SignOf(const PoseLayout& layout, const SE3& stored, const double* values) {
  double dot = 0;
  for (int k = 3; k < 7; ++k) dot += stored.data()[k] * values[PlaceOf(layout, stored, k)];
  return dot < 0 ? -1 : 1;
}

void ToStored(const PoseLayout& layout, const SE3& stored, double* values) {
  const double sign = SignOf(layout, stored, values);
  for (int k = 0; k < 7; ++k) {
    values[PlaceOf(layout, stored, k)] = (k < 3 ? 1 : sign) * stored.data()[k];
  }
}
template <typename G>
void ToStored(const PoseLayout& layout, const G& stored, double* values) {
  for (int k = 0; k < G::kDim; ++k) values[PlaceOf(layout, stored, k)] = stored.data()[k];
  double& angle = values[layout.rotation_at];
  angle += NormalizeAngle(stored.angle() - angle * AngleUnit(layout)) / AngleUnit(layout);
}

double ScaleOf(const PoseLayout& layout, const SE3& stored, const double* values, int k) {
  return k < 3 ? 1 : SignOf(layout, stored, values);
}
template <typename G>
double ScaleOf(const PoseLayout& layout, const G&, const double*, int k) {
  return k < G::kDim ? 1 : 1 / AngleUnit(layout);
}

}  // namespace

template <typename G>
G PoseCodec<G>::Read(const double* values) const {
  double numbers[G::kParams];
  for (int k = 0; k < G::kParams; ++k) numbers[k] = values[PlaceOf(layout_, G(), k)];
  const G stored = FromStored(layout_, G(), numbers);
  return IsInverse(layout_) ? stored.Inverse() : stored;
}

template <typename G>
void PoseCodec<G>::Write(const G& pose, double* values) const {
  ToStored(layout_, IsInverse(layout_) ? pose.Inverse() : pose, values);
}

template <typename G>
typename PoseCodec<G>::Jacobian PoseCodec<G>::WriteJacobian(const G& pose,
                                                            const double* values) const {
  const bool inverse = IsInverse(layout_);
  const G stored = inverse ? pose.Inverse() : pose;
  Jacobian by_storage = ceres_costs::RetractionJacobian(stored);
  // (X Exp(d))^-1 = X^-1 Exp(-Ad(X) d).
  if (inverse) by_storage = -by_storage * pose.Adjoint();
  Jacobian result;
  for (int k = 0; k < G::kParams; ++k) {
    result.row(PlaceOf(layout_, stored, k)) =
        ScaleOf(layout_, stored, values, k) * by_storage.row(k);
  }
  return result;
}

template class PoseCodec<SE2>;
template class PoseCodec<SE3>;
template class PoseCodec<YawPose>;

}  // namespace hpgo
