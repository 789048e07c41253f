#include "hpgo/graph/edge_classes.h"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace hpgo {

template <typename G>
std::vector<int> IdOrder(const PoseGraph<G>& graph) {
  std::vector<int> order(graph.nodes().size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return graph.nodes()[a].id < graph.nodes()[b].id; });
  return order;
}

template <typename G>
std::vector<bool> LoopClosures(const PoseGraph<G>& graph) {
  const std::vector<int> order = IdOrder(graph);
  std::vector<int> rank(order.size());
  for (int r = 0; r < static_cast<int>(order.size()); ++r) rank[order[r]] = r;
  std::vector<bool> linked(order.size(), false);  // by rank: an edge to the next one was seen
  std::vector<bool> closure(graph.edges().size(), true);
  for (std::size_t k = 0; k < closure.size(); ++k) {
    const int a = rank[graph.edges()[k].i], b = rank[graph.edges()[k].j];
    if (std::abs(a - b) != 1 || linked[std::min(a, b)]) continue;
    linked[std::min(a, b)] = true;
    closure[k] = false;
  }
  return closure;
}

template std::vector<bool> LoopClosures(const PoseGraph<SE2>&);
template std::vector<bool> LoopClosures(const PoseGraph<SE3>&);
template std::vector<bool> LoopClosures(const PoseGraph<YawPose>&);
template std::vector<int> IdOrder(const PoseGraph<SE2>&);
template std::vector<int> IdOrder(const PoseGraph<SE3>&);
template std::vector<int> IdOrder(const PoseGraph<YawPose>&);

}  // namespace hpgo
