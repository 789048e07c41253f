// 3D graphs whose roll and pitch are known, as graphs of gravity-aligned poses.
#pragma once

#include <vector>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// A graph over x, y, z and yaw with the nodes, edges and priors of a 3D one in their order, and
// what each node is turned by in its upright frame: X = Y * tilt, Y of this graph.
struct UprightGraph {
  PoseGraph<YawPose> graph;
  std::vector<Eigen::Quaterniond> tilts;  // by node index

  // The 3D pose of a node of this index.
  SE3 Tilted(int node, const YawPose& pose) const;
};

// Takes the roll and pitch of every node from its pose, in a world whose z is up, and turns the
// measurements upright by them: T_i_j becomes tilt_i * T_i_j * tilt_j^-1, of which the translation
// and the yaw remain, with the information that the edge has of these when the roll and pitch are
// right. Likewise priors: `convention` says what their information is of. kInvalidArgument for a
// node without a pose or with one that is none.
Result<UprightGraph> MakeUpright(const PoseGraph<SE3>& graph,
                                 ceres_costs::ErrorConvention convention);

}  // namespace hpgo
