// Connected components, and which nodes hold the gauge of each.
#pragma once

#include <vector>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

struct Components {
  std::vector<int> of_node;  // node index -> component, numbered in the order of their first nodes
  int count = 0;
};

template <typename G>
Components FindComponents(const PoseGraph<G>& graph);

// The indices of the nodes a full solve holds constant: the fixed ones and, for each component with
// neither a fixed node nor a prior, its first node in id order.
template <typename G>
std::vector<int> GaugeNodes(const PoseGraph<G>& graph, const Components& components);

}  // namespace hpgo
