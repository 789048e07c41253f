// What a picture shows of a pose graph: positions, the trajectory, the loop closures.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

struct PlotGraph {
  std::string label;                       // above the picture: "before", a file's name
  bool is_3d = false;                      // in 2D z is zero
  std::vector<Eigen::Vector3d> positions;  // world frame, metres
  // Runs of nodes that follow one another in id order and are connected by odometry; a node with no
  // odometry is a run of its own.
  std::vector<std::vector<int>> runs;
  std::vector<std::pair<int, int>> closures;
  int num_edges = 0;
  std::optional<double> chi2;  // shown if set
};

// kInvalidArgument, naming the node, if one has no pose or one that is not finite.
template <typename G>
Result<PlotGraph> MakePlotGraph(const PoseGraph<G>& graph, const std::string& label);

}  // namespace hpgo
