// A 3D trajectory seen on the ground plane, to compare a 2D estimate with.
#pragma once

#include <vector>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"

namespace hpgo {

enum class GroundPlane {
  kXy,  // z up, x forward: planar (x, y), heading of the x axis
  kXz,  // a camera frame, as KITTI's: x right, y down, z forward. Planar (z, -x), heading of the z
        // axis
};

// The position and the heading on the plane. A forward axis that stands upright on the plane has no
// heading: 0 is returned for it.
ceres_costs::SE2 ProjectToPlane(const ceres_costs::SE3& pose, GroundPlane plane);
std::vector<ceres_costs::SE2> ProjectToPlane(const std::vector<ceres_costs::SE3>& poses,
                                             GroundPlane plane);

}  // namespace hpgo
