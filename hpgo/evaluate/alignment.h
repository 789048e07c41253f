// The rigid transform that lays one trajectory on another.
#pragma once

#include <vector>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"
#include "hpgo/graph/status.h"

namespace hpgo {

enum class AlignmentMode {
  kIdentity,   // both already live in one frame
  kFirstPose,  // the first poses coincide, as where both start at the same place
  kRigid,      // least squares over all positions
};

// T_reference_estimate such that T_reference_estimate * estimate[k] lies near reference[k].
//
// kRigid is Umeyama's closed form without scale (S. Umeyama, "Least-squares estimation of
// transformation parameters between two point patterns", PAMI 1991, eq. 40-42): the rotation comes
// from the SVD of the positions' cross-covariance and is always proper, never a reflection. Where
// the positions leave a rotation open (one pose, a robot that stands still; in 3D a straight line),
// the orientations decide it, in the least-squares (chordal) sense.
//
// kInvalidArgument: the lengths differ, there is no pose, or a pose is not finite.
template <typename G>
Result<G> Align(const std::vector<G>& estimate, const std::vector<G>& reference,
                AlignmentMode mode);

}  // namespace hpgo
