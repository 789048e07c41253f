// The edges that agree least with the poses.
#pragma once

#include <string>
#include <vector>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/pose_graph.h"
#include "nlohmann/json.hpp"

namespace hpgo_cli {

struct ReportedEdge {
  hpgo::NodeId from = 0, to = 0;
  bool is_closure = false;
  double chi2 = 0;
  double translation_m = 0, rotation_deg = 0;  // of the deviation from the measurement
};

// The `count` edges with the largest chi2 in the convention, largest first.
template <typename G>
std::vector<ReportedEdge> FindWorstEdges(const hpgo::PoseGraph<G>& graph,
                                         ceres_costs::ErrorConvention convention, int count);

// A table with the share of the graph's chi2 `total`, handed over line by line.
void PrintWorstEdges(const std::vector<ReportedEdge>& edges, double total,
                     void (*print_line)(const std::string&));

nlohmann::ordered_json WorstEdgesJson(const std::vector<ReportedEdge>& edges);

}  // namespace hpgo_cli
