// Optimizer: asking.

#include <limits>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/marginal.h"

namespace hpgo {

template <typename G>
Result<G> Optimizer<G>::Impl::GetPose(NodeId id) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  return hierarchy_.WorldPose(0, *node);
}

template <typename G>
Result<typename Optimizer<G>::Group> Optimizer<G>::Impl::GetGroup(NodeId id, int level) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  if (level < 0 || level >= hierarchy_.num_levels()) {
    return Status(StatusCode::kInvalidArgument, "no level " + std::to_string(level));
  }
  const Index group = hierarchy_.Ancestor(*node, level);
  if (group == kNone) {
    return Status(StatusCode::kNotFound,
                  "node " + std::to_string(id) + " has no group yet: update first");
  }
  return Group{group, hierarchy_.WorldPose(level, group)};
}

template <typename G>
void Optimizer<G>::Impl::ForEachPose(const std::function<void(NodeId, const G&)>& visit) const {
  index_of_.ForEach([&](NodeId id, Index node) { visit(id, hierarchy_.WorldPose(0, node)); });
}

template <typename G>
void Optimizer<G>::Impl::ForEachMoved(double distance, double angle,
                                      const std::function<void(NodeId, const G&)>& visit) {
  hierarchy_.ForEachMoved(distance, angle,
                          [&](Index node, const G& pose) { visit(ids_[node], pose); });
}

template <typename G>
EdgeError Optimizer<G>::Impl::ErrorOf(Index e) const {
  const LevelEdge& edge = hierarchy_.level(0).edges[e];
  ceres_costs::FactorTerm<G> factor = hierarchy_.FactorOf(0, e);
  factor.loss = nullptr;
  EdgeError error;
  error.id = IdOf(e);
  error.j = ids_[edge.node[1]];
  error.i = edge.node[0] == kNone ? error.j : ids_[edge.node[0]];
  error.chi2 = FactorCost(factor, edge.node[0] == kNone,
                          hierarchy_.RelativePose(0, edge.node[0], edge.node[1]));
  return error;
}

template <typename G>
std::vector<EdgeError> Optimizer<G>::Impl::EdgeErrors() const {
  std::vector<EdgeError> errors;
  const Level<G>& level = hierarchy_.level(0);
  errors.reserve(level.num_edges);
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    if (level.edges[e].alive) errors.push_back(ErrorOf(e));
  }
  return errors;
}

template <typename G>
Result<EdgeError> Optimizer<G>::Impl::GetEdgeError(EdgeId id) const {
  const Result<Index> edge = FindEdge(id);
  if (!edge.ok()) return edge.status();
  return ErrorOf(*edge);
}

template <typename G>
double Optimizer<G>::Impl::Cost() const {
  const Level<G>& level = hierarchy_.level(0);
  double cost = 0;
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    const LevelEdge& edge = level.edges[e];
    if (!edge.alive) continue;
    cost += FactorCost(hierarchy_.FactorOf(0, e), edge.node[0] == kNone,
                       hierarchy_.RelativePose(0, edge.node[0], edge.node[1]));
  }
  return cost;
}

template <typename G>
Result<typename G::Matrix> Optimizer<G>::Impl::MarginalCovariance(NodeId id) {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  window_.BuildWhole(0, &hierarchy_);
  if (!window_.IsFree(*node)) return Matrix(Matrix::Zero());  // it is held: known exactly
  return hpgo::MarginalCovariance(window_.subproblem(), hierarchy_.level(0).nodes[*node].scratch);
}

template <typename G>
PoseGraph<G> Optimizer<G>::Impl::ToGraph() const {
  PoseGraph<G> graph;
  const Level<G>& level = hierarchy_.level(0);
  graph.Reserve(level.num_nodes, level.num_edges);
  std::vector<int> position(level.nodes.size(), -1);
  index_of_.ForEach([&](NodeId id, Index n) {
    GraphNode<G> node;
    node.id = id;
    node.pose = hierarchy_.WorldPose(0, n).Normalized();
    node.fixed = fixed_.count(n) > 0;
    position[n] = *graph.AddNode(node);
  });
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    const LevelEdge& edge = level.edges[e];
    if (!edge.alive) continue;
    Status status;
    if (edge.node[0] == kNone) {
      GraphPrior<G> prior;
      prior.node = position[edge.node[1]];
      prior.measurement = level.terms[e].measurement;
      prior.information = level.terms[e].information.Dense();
      const ceres_costs::FactorTerm<G> factor = hierarchy_.FactorOf(0, e);
      if (factor.offset != nullptr) prior.offset = *factor.offset;
      status = graph.AddPrior(prior);
    } else {
      GraphEdge<G> copy;
      copy.i = position[edge.node[0]];
      copy.j = position[edge.node[1]];
      copy.measurement = level.terms[e].measurement;
      copy.information = level.terms[e].information.Dense();
      status = graph.AddEdge(copy);
    }
    CHECK(status.ok()) << status.ToString();
  }
  return graph;
}

template <typename G>
std::size_t Optimizer<G>::Impl::MemoryBytes() const {
  return hierarchy_.MemoryBytes() + index_of_.MemoryBytes() + ids_.MemoryBytes();
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
