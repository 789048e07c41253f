#include "hpgo/report/plot_graph.h"

#include <algorithm>

#include "hpgo/graph/edge_classes.h"

namespace hpgo {
namespace {

Eigen::Vector3d Position(const SE2& pose) {
  return {pose.translation().x(), pose.translation().y(), 0};
}
Eigen::Vector3d Position(const SE3& pose) { return pose.translation(); }

// For every place in id order, true if odometry leads from the node before to the one there.
template <typename G>
std::vector<char> ContinuesRun(const PoseGraph<G>& graph, const std::vector<int>& order,
                               const std::vector<bool>& is_closure) {
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  std::vector<char> continues(order.size(), 0);
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    const GraphEdge<G>& edge = graph.edges()[k];
    if (!is_closure[k]) continues[std::max(place[edge.i], place[edge.j])] = 1;
  }
  return continues;
}

}  // namespace

template <typename G>
Result<PlotGraph> MakePlotGraph(const PoseGraph<G>& graph, const std::string& label) {
  PlotGraph plot;
  plot.label = label;
  plot.is_3d = G::kDim == 3;
  plot.num_edges = static_cast<int>(graph.edges().size());
  plot.positions.reserve(graph.nodes().size());
  for (const GraphNode<G>& node : graph.nodes()) {
    plot.positions.push_back(Position(node.pose));
    if (!node.has_pose || !plot.positions.back().allFinite()) {
      return Status(StatusCode::kInvalidArgument,
                    "node " + std::to_string(node.id) + " has no finite pose to draw");
    }
  }
  const std::vector<bool> is_closure = LoopClosures(graph);
  const std::vector<int> order = IdOrder(graph);
  const std::vector<char> continues = ContinuesRun(graph, order, is_closure);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (continues[k] == 0) plot.runs.emplace_back();
    plot.runs.back().push_back(order[k]);
  }
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    if (is_closure[k]) plot.closures.emplace_back(graph.edges()[k].i, graph.edges()[k].j);
  }
  return plot;
}

template Result<PlotGraph> MakePlotGraph<SE2>(const PoseGraph<SE2>&, const std::string&);
template Result<PlotGraph> MakePlotGraph<SE3>(const PoseGraph<SE3>&, const std::string&);

}  // namespace hpgo
