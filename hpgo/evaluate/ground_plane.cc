#include "hpgo/evaluate/ground_plane.h"

#include <cmath>

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;

SE2 ProjectToPlane(const SE3& pose, GroundPlane plane) {
  const SE3::RotationMatrix r = pose.matrix();
  const auto t = pose.translation();
  if (plane == GroundPlane::kXz) return SE2(t(2), -t(0), std::atan2(-r(0, 2), r(2, 2)));
  return SE2(t(0), t(1), std::atan2(r(1, 0), r(0, 0)));
}

std::vector<SE2> ProjectToPlane(const std::vector<SE3>& poses, GroundPlane plane) {
  std::vector<SE2> planar;
  planar.reserve(poses.size());
  for (const SE3& pose : poses) planar.push_back(ProjectToPlane(pose, plane));
  return planar;
}

}  // namespace hpgo
