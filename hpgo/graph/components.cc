#include "hpgo/graph/components.h"

#include <algorithm>
#include <numeric>

namespace hpgo {
namespace {

int Root(std::vector<int>* parent, int i) {
  std::vector<int>& p = *parent;
  while (p[i] != i) i = p[i] = p[p[i]];
  return i;
}

}  // namespace

template <typename G>
Components FindComponents(const PoseGraph<G>& graph) {
  const int size = static_cast<int>(graph.nodes().size());
  std::vector<int> parent(size);
  std::iota(parent.begin(), parent.end(), 0);
  for (const GraphEdge<G>& edge : graph.edges()) {
    const int a = Root(&parent, edge.i), b = Root(&parent, edge.j);
    parent[std::max(a, b)] = std::min(a, b);
  }
  Components components;
  components.of_node.resize(size);
  for (int i = 0; i < size; ++i) {
    const int root = Root(&parent, i);  // never after i: roots are the smallest of their sets
    components.of_node[i] = root == i ? components.count++ : components.of_node[root];
  }
  return components;
}

template <typename G>
std::vector<int> GaugeNodes(const PoseGraph<G>& graph, const Components& components) {
  std::vector<bool> held(components.count, false);
  for (const GraphPrior<G>& prior : graph.priors()) held[components.of_node[prior.node]] = true;
  std::vector<int> first(components.count, -1), gauge;
  for (int i = 0; i < static_cast<int>(graph.nodes().size()); ++i) {
    const int c = components.of_node[i];
    if (graph.nodes()[i].fixed) {
      held[c] = true;
      gauge.push_back(i);
    }
    if (first[c] < 0 || graph.nodes()[i].id < graph.nodes()[first[c]].id) first[c] = i;
  }
  for (int c = 0; c < components.count; ++c) {
    if (!held[c]) gauge.push_back(first[c]);
  }
  return gauge;
}

template Components FindComponents(const PoseGraph<SE2>&);
template Components FindComponents(const PoseGraph<SE3>&);
template Components FindComponents(const PoseGraph<YawPose>&);
template std::vector<int> GaugeNodes(const PoseGraph<SE2>&, const Components&);
template std::vector<int> GaugeNodes(const PoseGraph<SE3>&, const Components&);
template std::vector<int> GaugeNodes(const PoseGraph<YawPose>&, const Components&);

}  // namespace hpgo
