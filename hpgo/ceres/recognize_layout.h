// What the numbers of a problem's poses mean, found by trying.
#pragma once

#include <string>

#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/pose_layout.h"
#include "hpgo/ceres/problem_view.h"

namespace hpgo {

// Completes what is declared. The order and place of a quaternion: those for which the manifold's
// Plus composes the quaternion, from the left or the right, with what it makes of the identity.
// Direction, place of the angle and its unit: those for which the costs over two poses do not
// change when both are moved together. Evaluates costs and manifolds on copies. False with the
// reason where nothing fits, or several readings do.
[[nodiscard]] bool RecognizeLayout(const ProblemView& problem, const PoseBlocks& poses,
                                   const PoseLayout& declared, PoseLayout* layout,
                                   std::string* reason);

}  // namespace hpgo
