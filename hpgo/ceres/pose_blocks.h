// Which parameter blocks of a problem are one pose.
#pragma once

#include <string>
#include <vector>

#include "hpgo/ceres/pose_layout.h"
#include "hpgo/ceres/problem_view.h"

namespace hpgo {

struct PoseBlocks {
  std::vector<int> sizes;      // of the blocks of a pose; see PoseLayout
  std::vector<int> blocks;     // pose p has blocks[p * sizes.size()] and the following
  std::vector<int> pose_of;    // by block; -1: none
  std::vector<int> column_of;  // by block: where its tangent begins in that of its pose
  int max_dof = 0;             // tangent sizes of a pose, added up

  int num_poses() const {
    return sizes.empty() ? 0 : static_cast<int>(blocks.size() / sizes.size());
  }
  int BlockOf(int pose, int k) const { return blocks[pose * sizes.size() + k]; }
};

// "x, y, yaw", "translation and quaternion" and the like, for messages.
std::string LayoutName(const std::vector<int>& sizes);

// Finds the sizes for which the blocks of every residual over two poses fall into two runs of them,
// and each other residual is over blocks of one or two of these poses, constant blocks aside.
// `sizes`, unless empty, are the only ones tried. False with the reason where there are none.
[[nodiscard]] bool FindPoseBlocks(const ProblemView& problem, const std::vector<int>& sizes,
                                  PoseBlocks* poses, std::string* reason);

}  // namespace hpgo
