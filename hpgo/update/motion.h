// How far one pose is from another.
#pragma once

#include <algorithm>
#include <cmath>

#include "ceres_costs/se3.h"
#include "hpgo/update/report.h"

namespace hpgo {

// Grows with the angle; about half of it where it is small.
template <typename G>
double HalfRotation(const G& T) {
  return 0.5 * std::abs(T.angle());
}
inline double HalfRotation(const ceres_costs::SE3& T) { return T.rotation().vec().norm(); }

template <typename G>
double Angle(const G& T) {
  return std::abs(T.angle());
}
inline double Angle(const ceres_costs::SE3& T) {
  return 2 * std::asin(std::min(1., T.rotation().vec().norm()));
}

template <typename G>
Motion MotionBetween(const G& before, const G& after) {
  const G moved = before.Between(after);
  return {moved.translation().norm(), Angle(moved)};
}

}  // namespace hpgo
