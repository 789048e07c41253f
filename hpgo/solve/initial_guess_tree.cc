#include "hpgo/solve/initial_guess_tree.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <utility>

#include "Eigen/LU"
#include "ceres_costs/symmetric_eigen.h"
#include "hpgo/graph/edge_classes.h"

namespace hpgo {
namespace {

// The edges at each node, in compressed rows: those of node i are edges[begin[i]] ..
// edges[begin[i + 1] - 1].
struct Incidence {
  std::vector<int> begin, edges;
};

template <typename G>
Incidence MakeIncidence(const PoseGraph<G>& graph) {
  Incidence incidence;
  incidence.begin.assign(graph.nodes().size() + 2, 0);
  for (const GraphEdge<G>& edge : graph.edges()) {
    ++incidence.begin[edge.i + 2];
    ++incidence.begin[edge.j + 2];
  }
  for (std::size_t k = 2; k < incidence.begin.size(); ++k) {
    incidence.begin[k] += incidence.begin[k - 1];
  }
  incidence.edges.resize(2 * graph.edges().size());
  for (int k = 0; k < static_cast<int>(graph.edges().size()); ++k) {
    incidence.edges[incidence.begin[graph.edges()[k].i + 1]++] = k;
    incidence.edges[incidence.begin[graph.edges()[k].j + 1]++] = k;
  }
  return incidence;
}

template <typename G>
bool HasFullRank(const typename G::Matrix& information) {
  const auto values = ceres_costs::EigenvaluesOf<G::kDof>(information);
  return values(0) > 1e-12 * values(G::kDof - 1);
}

}  // namespace

template <typename G>
std::vector<Anchor<G>> FindAnchors(const PoseGraph<G>& graph, const Components& components) {
  std::vector<Anchor<G>> anchors;
  std::vector<bool> anchored(components.count, false);
  const std::vector<int> order = IdOrder(graph);
  for (const bool with_pose : {true, false}) {
    for (const int i : order) {
      const GraphNode<G>& node = graph.nodes()[i];
      if (!node.fixed || node.has_pose != with_pose) continue;
      if (!with_pose && anchored[components.of_node[i]]) continue;
      anchors.push_back({i, with_pose ? node.pose : G(), true});
      anchored[components.of_node[i]] = true;
    }
  }
  for (const GraphPrior<G>& prior : graph.priors()) {
    const int c = components.of_node[prior.node];
    if (anchored[c] || !HasFullRank<G>(prior.information)) continue;
    anchors.push_back({prior.node, prior.measurement * prior.offset.Inverse(), true});
    anchored[c] = true;
  }
  for (const int i : order) {
    const GraphNode<G>& node = graph.nodes()[i];
    if (anchored[components.of_node[i]]) continue;
    anchors.push_back({i, node.has_pose ? node.pose : G(), false});
    anchored[components.of_node[i]] = true;
  }
  return anchors;
}

template <typename G>
std::vector<G> ComposeAlongShortestPaths(const PoseGraph<G>& graph,
                                         const std::vector<Anchor<G>>& anchors,
                                         const std::vector<double>& lengths) {
  const Incidence incidence = MakeIncidence(graph);
  std::vector<G> poses(graph.nodes().size());
  std::vector<double> distance(poses.size(), std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, int>;  // ties go to the smaller index: the order is defined
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  for (const Anchor<G>& anchor : anchors) {
    poses[anchor.node] = anchor.pose;
    distance[anchor.node] = 0;
    queue.emplace(0.0, anchor.node);
  }
  while (!queue.empty()) {
    const auto [reached, i] = queue.top();
    queue.pop();
    if (reached > distance[i]) continue;
    for (int slot = incidence.begin[i]; slot < incidence.begin[i + 1]; ++slot) {
      const int k = incidence.edges[slot];
      const GraphEdge<G>& edge = graph.edges()[k];
      const int other = edge.i == i ? edge.j : edge.i;
      if (!(reached + lengths[k] < distance[other])) continue;
      distance[other] = reached + lengths[k];
      // Not quite unit quaternions would grow along a path of thousands of edges.
      const G Z = edge.measurement.Normalized();
      poses[other] = (poses[i] * (edge.i == i ? Z : Z.Inverse())).Normalized();
      queue.emplace(distance[other], other);
    }
  }
  return poses;
}

template <typename G>
std::vector<double> OdometryLengths(const PoseGraph<G>& graph) {
  const std::vector<bool> closure = LoopClosures(graph);
  // Longer than any path of odometry edges.
  const double detour = 1.0 + static_cast<double>(graph.nodes().size());
  std::vector<double> lengths(closure.size());
  std::transform(closure.begin(), closure.end(), lengths.begin(),
                 [&](bool is_closure) { return is_closure ? detour : 1.0; });
  return lengths;
}

template <typename G>
std::vector<double> UncertaintyLengths(const PoseGraph<G>& graph) {
  std::vector<double> lengths(graph.edges().size());
  double longest = 0;
  for (std::size_t k = 0; k < lengths.size(); ++k) {
    const double determinant = graph.edges()[k].information.determinant();
    lengths[k] = determinant > 0 ? std::pow(determinant, -1.0 / G::kDof) : -1;
    longest = std::max(longest, lengths[k]);
  }
  // A semi-definite edge leaves part of the pose undefined: the last resort.
  const double detour = std::max(longest, 1.0) * (1.0 + static_cast<double>(graph.nodes().size()));
  std::replace(lengths.begin(), lengths.end(), -1.0, detour);
  return lengths;
}

template std::vector<Anchor<SE2>> FindAnchors(const PoseGraph<SE2>&, const Components&);
template std::vector<Anchor<SE3>> FindAnchors(const PoseGraph<SE3>&, const Components&);
template std::vector<Anchor<YawPose>> FindAnchors(const PoseGraph<YawPose>&, const Components&);
template std::vector<SE2> ComposeAlongShortestPaths(const PoseGraph<SE2>&,
                                                    const std::vector<Anchor<SE2>>&,
                                                    const std::vector<double>&);
template std::vector<SE3> ComposeAlongShortestPaths(const PoseGraph<SE3>&,
                                                    const std::vector<Anchor<SE3>>&,
                                                    const std::vector<double>&);
template std::vector<YawPose> ComposeAlongShortestPaths(const PoseGraph<YawPose>&,
                                                        const std::vector<Anchor<YawPose>>&,
                                                        const std::vector<double>&);
template std::vector<double> OdometryLengths(const PoseGraph<SE2>&);
template std::vector<double> OdometryLengths(const PoseGraph<SE3>&);
template std::vector<double> OdometryLengths(const PoseGraph<YawPose>&);
template std::vector<double> UncertaintyLengths(const PoseGraph<SE2>&);
template std::vector<double> UncertaintyLengths(const PoseGraph<SE3>&);
template std::vector<double> UncertaintyLengths(const PoseGraph<YawPose>&);

}  // namespace hpgo
