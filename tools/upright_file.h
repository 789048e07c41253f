// --dof=4: a 3D file as a graph of gravity-aligned poses, and its poses back.
#pragma once

#include <string>

#include "hpgo/graph/upright.h"

namespace hpgo_cli {

// What is wrong with the value of --dof, and with it for a file of this dimension; empty if nothing
// is.
std::string DofFlagProblem();
std::string DofMisfit(int dimension, const std::string& name);

// The file's graph with roll and pitch taken from its vertices; errors name the file. See
// hpgo::MakeUpright.
hpgo::Result<hpgo::UprightGraph> MakeUpright(const hpgo::PoseGraph<hpgo::SE3>& graph,
                                             const std::string& name);

// The nodes, edges and priors of `whole` with the poses of those nodes that `estimate` has, and
// none of the others; fixed ones stay as they are.
hpgo::PoseGraph<hpgo::SE3> WithUprightPoses(const hpgo::PoseGraph<hpgo::SE3>& whole,
                                            const hpgo::UprightGraph& upright,
                                            const hpgo::PoseGraph<hpgo::YawPose>& estimate);

}  // namespace hpgo_cli
