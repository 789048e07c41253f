// Optimizer: asking.

#include <limits>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/hierarchy/consistency.h"
#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/level_problem.h"

namespace hpgo {

template <typename G>
Result<G> Optimizer<G>::Impl::GetPose(NodeId id) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  return graph_.WorldPose(*node);
}

template <typename G>
Result<typename Optimizer<G>::Group> Optimizer<G>::Impl::GetGroup(NodeId id, int level) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  if (level < 0 || level >= hierarchy_.num_levels()) {
    return Status(StatusCode::kInvalidArgument, "no level " + std::to_string(level));
  }
  const Index kept = graph_.KeptNear(*node);
  const Index group = kept == kNone ? kNone : hierarchy_.Ancestor(graph_.LevelNodeOf(kept), level);
  if (group == kNone) {
    return Status(StatusCode::kNotFound,
                  "node " + std::to_string(id) + " has no group yet: update first");
  }
  return Group{group, hierarchy_.WorldPose(level, group)};
}

template <typename G>
void Optimizer<G>::Impl::ForEachPose(const std::function<void(NodeId, const G&)>& visit) const {
  std::vector<G> poses(ids_.size());
  graph_.ForEachPose([&](Index node, const G& pose) { poses[node] = pose; });
  index_of_.ForEach([&](NodeId id, Index node) { visit(id, poses[node]); });
}

template <typename G>
void Optimizer<G>::Impl::ForEachMoved(double distance, double angle,
                                      const std::function<void(NodeId, const G&)>& visit) {
  graph_.ForEachMoved(distance, angle, [&](Index node, const G& pose) { visit(ids_[node], pose); });
}

template <typename G>
EdgeError Optimizer<G>::Impl::ErrorOf(Index e, const G& T_i_j) const {
  ceres_costs::FactorTerm<G> factor = graph_.FactorOf(e);
  factor.loss = nullptr;
  EdgeError error;
  error.id = IdOf(e);
  error.j = ids_[graph_.End(e, 1)];
  const bool unary = graph_.End(e, 0) == kNone;
  error.i = unary ? error.j : ids_[graph_.End(e, 0)];
  error.chi2 = FactorCost(factor, unary, T_i_j);
  return error;
}

template <typename G>
std::vector<EdgeError> Optimizer<G>::Impl::EdgeErrors() const {
  std::vector<EdgeError> by_index(graph_.end_of_edges());
  graph_.ForEachRelativePose([&](Index e, const G& T) { by_index[e] = ErrorOf(e, T); });
  std::vector<EdgeError> errors;
  errors.reserve(graph_.num_edges());
  for (Index e = 0; e < graph_.end_of_edges(); ++e) {
    if (graph_.IsEdge(e)) errors.push_back(by_index[e]);
  }
  return errors;
}

template <typename G>
Result<EdgeError> Optimizer<G>::Impl::GetEdgeError(EdgeId id) const {
  const Result<Index> edge = FindEdge(id);
  if (!edge.ok()) return edge.status();
  return ErrorOf(*edge, graph_.RelativePose(*edge));
}

template <typename G>
Result<std::shared_ptr<CeresLevel<G>>> Optimizer<G>::Impl::LevelProblem(int level) {
  return CeresLevel<G>::Make(level, &hierarchy_);
}

template <typename G>
PoseGraph<G> Optimizer<G>::Impl::ToGraph() const {
  PoseGraph<G> graph;
  graph.Reserve(graph_.num_nodes(), graph_.num_edges());
  std::vector<int> position(ids_.size(), -1);
  ForEachPose([&](NodeId id, const G& pose) {
    const Index n = index_of_.Find(id);
    GraphNode<G> node;
    node.id = id;
    node.pose = pose.Normalized();
    node.fixed = gauge_.IsFixed(n);
    position[n] = *graph.AddNode(node);
  });
  for (Index e = 0; e < graph_.end_of_edges(); ++e) {
    if (!graph_.IsEdge(e)) continue;
    const ceres_costs::FactorTerm<G> factor = graph_.FactorOf(e);
    Status status;
    if (graph_.End(e, 0) == kNone) {
      GraphPrior<G> prior;
      prior.node = position[graph_.End(e, 1)];
      prior.measurement = factor.term->measurement;
      prior.information = factor.term->information.Dense();
      if (factor.offset != nullptr) prior.offset = *factor.offset;
      status = graph.AddPrior(prior);
    } else {
      GraphEdge<G> copy;
      copy.i = position[graph_.End(e, 0)];
      copy.j = position[graph_.End(e, 1)];
      copy.measurement = factor.term->measurement;
      copy.information = factor.term->information.Dense();
      status = graph.AddEdge(copy);
    }
    CHECK(status.ok()) << status.ToString();
  }
  return graph;
}

template <typename G>
std::size_t Optimizer<G>::Impl::MemoryBytes() const {
  return graph_.MemoryBytes() + index_of_.MemoryBytes() + ids_.MemoryBytes();
}

template <typename G>
std::string Optimizer<G>::Impl::FindInconsistency() {
  const std::string wrong = graph_.FindInconsistency();
  return wrong.empty() ? hpgo::FindInconsistency(hierarchy_) : wrong;
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;
template class Optimizer<YawPose>::Impl;

}  // namespace hpgo
