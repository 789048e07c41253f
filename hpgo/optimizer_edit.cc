// Optimizer: adding, changing and removing.

#include <algorithm>
#include <cmath>

#include "ceres_costs/common_motion.h"
#include "hpgo/graph/compose_poses.h"
#include "hpgo/graph/validate.h"
#include "hpgo/optimizer_impl.h"

namespace hpgo {
namespace {

template <typename G>
ceres_costs::RelativePoseTerm<G> Normalized(ceres_costs::RelativePoseTerm<G> term) {
  term.measurement = term.measurement.Normalized();
  return term;
}

}  // namespace

template <typename G>
Optimizer<G>::Impl::Impl(const OptimizerOptions& options)
    : options_(options),
      graph_({options.max_group_size, options.max_top_nodes, options.max_top_edges,
              options.coarse_edges, options.convention},
             options.condense_chains),
      hierarchy_(graph_.hierarchy()),
      updater_(options, &graph_, [this](Index e) { return NameOfLevelEdge(e); }) {}

template <typename G>
EdgeId Optimizer<G>::Impl::IdOf(Index edge) const {
  return {static_cast<std::int64_t>(graph_.Generation(edge)) << 32 | edge};
}

template <typename G>
Result<Index> Optimizer<G>::Impl::FindEdge(EdgeId id) const {
  const std::int64_t index = id.value & 0xffffffff;
  if (id.value < 0 || index >= graph_.end_of_edges() || !graph_.IsEdge(static_cast<Index>(index)) ||
      graph_.Generation(static_cast<Index>(index)) != id.value >> 32) {
    return Status(StatusCode::kNotFound, "no edge with the id " + std::to_string(id.value));
  }
  return static_cast<Index>(index);
}

template <typename G>
Result<Index> Optimizer<G>::Impl::FindNode(NodeId id) const {
  const Index node = index_of_.Find(id);
  if (node == IdMap::kAbsent) {
    return Status(StatusCode::kNotFound, "no node " + std::to_string(id));
  }
  return node;
}

template <typename G>
std::string Optimizer<G>::Impl::NameOf(Index edge) const {
  const Index i = graph_.End(edge, 0), j = graph_.End(edge, 1);
  return i == kNone ? PriorName(ids_[j]) : EdgeName(ids_[i], ids_[j]);
}

template <typename G>
std::string Optimizer<G>::Impl::NameOfLevelEdge(Index level_edge) const {
  const Index edge = graph_.EdgeOfLevel(level_edge);
  if (edge != kNone) return NameOf(edge);
  return "chain " + std::to_string(ids_[graph_.EndOfLevel(level_edge, 0)]) + " -> " +
         std::to_string(ids_[graph_.EndOfLevel(level_edge, 1)]);
}

// What has changed since this was last asked.
template <typename G>
Changes Optimizer<G>::Impl::TakeChanges() {
  Changes changes;
  changes.num_nodes = static_cast<int>(new_nodes_.size());
  changes.num_edges = static_cast<int>(new_edges_.size());
  for (const EdgeId id : new_edges_) {
    const Result<Index> edge = FindEdge(id);
    if (edge.ok()) changes.edges.push_back(*edge);  // else removed since
  }
  changes.disturbed.swap(disturbed_);
  changes.newest = newest_;
  new_nodes_.clear();
  new_edges_.clear();
  return changes;
}

template <typename G>
Status Optimizer<G>::Impl::AddNode(NodeId id, const G& pose) {
  if (index_of_.Find(id) != IdMap::kAbsent) {
    return Status(StatusCode::kAlreadyExists, "node " + std::to_string(id) + " exists");
  }
  const Status status = CheckPose(pose, "node " + std::to_string(id) + ": the pose");
  if (!status.ok()) return status;
  const Index node = graph_.AddNode(pose);
  while (static_cast<Index>(ids_.size()) <= node) ids_.push_back(0);
  ids_[node] = id;
  index_of_.Set(id, node);
  NoteGivenPose(node, pose);
  new_nodes_.push_back(node);
  newest_ = node;
  return Status::Ok();
}

template <typename G>
Index Optimizer<G>::Impl::Link(Index i, Index j, const EdgeData<G>& data) {
  const Index edge = graph_.AddEdge(i, j, data);
  new_edges_.push_back(IdOf(edge));
  return edge;
}

template <typename G>
Result<EdgeId> Optimizer<G>::Impl::AddEdge(NodeId i, NodeId j, EdgeData<G> data) {
  const Result<Index> a = FindNode(i), b = FindNode(j);
  if (!a.ok()) return Status(a.status().code(), EdgeName(i, j) + ": " + a.status().message());
  if (!b.ok()) return Status(b.status().code(), EdgeName(i, j) + ": " + b.status().message());
  if (i == j) return Status(StatusCode::kInvalidArgument, EdgeName(i, j) + ": a self edge");
  if (data.custom != nullptr) {
    const std::string problem = ceres_costs::CommonMotionProblem(
        *data.custom, graph_.WorldPose(*a).Between(graph_.WorldPose(*b)));
    if (!problem.empty()) {
      return Status(StatusCode::kInvalidArgument, EdgeName(i, j) + ": " + problem);
    }
  }
  data.term = Normalized(data.term);
  data.weight = ModularityWeight(data.term);
  gauge_.NoteEdge();
  return IdOf(Link(*a, *b, data));
}

template <typename G>
Result<EdgeId> Optimizer<G>::Impl::AddPrior(NodeId id, EdgeData<G> data) {
  const Result<Index> node = FindNode(id);
  const std::string name = PriorName(id);
  if (!node.ok()) return Status(node.status().code(), name + ": " + node.status().message());
  if (data.custom != nullptr) {
    ceres_costs::FactorTerm<G> factor;
    factor.custom = data.custom.get();
    if (!std::isfinite(FactorCost(factor, true, graph_.WorldPose(*node)))) {
      return Status(StatusCode::kInvalidArgument,
                    name + ": its cost cannot be evaluated at the estimate");
    }
  }
  data.term = Normalized(data.term);
  data.offset = std::make_shared<G>(data.offset->Normalized());
  gauge_.NotePriors(1);
  return IdOf(Link(kNone, *node, data));
}

template <typename G>
Status Optimizer<G>::Impl::UpdateEdge(EdgeId id, const G& measurement, const Matrix& information,
                                      const Loss* loss) {
  const Result<Index> edge = FindEdge(id);
  if (!edge.ok()) return edge.status();
  ceres_costs::RelativePoseTerm<G> term;
  term.measurement = measurement;
  term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
  Status status = CheckMeasurement(measurement, information, NameOf(*edge));
  if (status.ok() && graph_.FactorOf(*edge).custom != nullptr) {
    status = Status(StatusCode::kInvalidArgument,
                    NameOf(*edge) + ": its cost is the caller's own; remove it and add another");
  }
  if (!status.ok()) return status;
  graph_.UpdateEdge(*edge, Normalized(term));
  if (loss != nullptr) graph_.SetLoss(*edge, *loss);
  new_edges_.push_back(id);
  return Status::Ok();
}

template <typename G>
Status Optimizer<G>::Impl::RemoveEdge(EdgeId id) {
  const Result<Index> edge = FindEdge(id);
  if (!edge.ok()) return edge.status();
  const Index ends[2] = {graph_.End(*edge, 0), graph_.End(*edge, 1)};
  graph_.RemoveEdge(*edge);
  if (ends[0] == kNone) gauge_.NotePriors(-1);
  gauge_.NoteRemoval();
  for (const Index end : ends) {
    if (end != kNone) disturbed_.push_back(end);
  }
  return Status::Ok();
}

template <typename G>
Status Optimizer<G>::Impl::RemoveNode(NodeId id) {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  graph_.ForEachEdgeOf(*node, [&](Index, Index other) {
    if (other == kNone) {
      gauge_.NotePriors(-1);
    } else {
      disturbed_.push_back(other);
    }
  });
  gauge_.Forget(*node);
  new_nodes_.erase(std::remove(new_nodes_.begin(), new_nodes_.end(), *node), new_nodes_.end());
  if (newest_ == *node) newest_ = kNone;
  ForgetNode(*node);
  graph_.RemoveNode(*node);
  index_of_.Erase(id);
  return Status::Ok();
}

template <typename G>
Status Optimizer<G>::Impl::SetFixed(NodeId id, bool fixed) {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  if (gauge_.SetFixed(*node, fixed, &graph_) && !fixed) disturbed_.push_back(*node);
  return Status::Ok();
}

template <typename G>
Status Optimizer<G>::Impl::SetPose(NodeId id, const G& pose) {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  const Status status = CheckPose(pose, "node " + std::to_string(id) + ": the pose");
  if (!status.ok()) return status;
  graph_.SetWorldPose(*node, pose.Normalized());
  NoteGivenPose(*node, pose);
  // Its edges have changed as much as new ones.
  graph_.ForEachEdgeOf(*node, [&](Index e, Index) { new_edges_.push_back(IdOf(e)); });
  const Level<G>& level = hierarchy_.level(0);
  if (!graph_.IsKept(*node)) return Status::Ok();
  ForEachEdge(level, graph_.LevelNodeOf(*node), [&](Index e, Index) {
    for (Index f = level.edges[e].parent, l = 1; f != kNone;
         f = hierarchy_.level(l++).edges[f].parent) {
      hierarchy_.MarkDirty(l, f);
    }
  });
  return Status::Ok();
}

template <typename G>
Status Optimizer<G>::Impl::AddGraph(const PoseGraph<G>& graph) {
  // Everything is checked first, so that nothing is added of a graph with an error in it.
  for (const GraphNode<G>& node : graph.nodes()) {
    if (index_of_.Find(node.id) == IdMap::kAbsent) continue;
    return Status(StatusCode::kAlreadyExists, "node " + std::to_string(node.id) + " exists");
  }
  Status status = CheckGraph(graph);
  if (!status.ok()) return status;
  PoseGraph<G> complete = graph;
  ComposeMissingPoses(&complete);
  for (const GraphNode<G>& node : complete.nodes()) {
    status = CheckPose(node.pose, "node " + std::to_string(node.id) + ": the composed pose");
    if (!status.ok()) return status;
  }
  const auto id = [&](int index) { return graph.nodes()[index].id; };
  for (const GraphNode<G>& node : complete.nodes()) {
    if (status.ok()) status = AddNode(node.id, node.pose);
    if (status.ok() && node.fixed) status = SetFixed(node.id, true);
  }
  for (const GraphEdge<G>& edge : graph.edges()) {
    EdgeData<G> data;
    data.term.measurement = edge.measurement;
    data.term.information = ceres_costs::PackedSymmetric<G::kDof>(edge.information);
    if (status.ok()) status = AddEdge(id(edge.i), id(edge.j), data).status();
  }
  for (const GraphPrior<G>& prior : graph.priors()) {
    EdgeData<G> data;
    data.term.measurement = prior.measurement;
    data.term.information = ceres_costs::PackedSymmetric<G::kDof>(prior.information);
    data.offset = std::make_shared<G>(prior.offset);
    if (status.ok()) status = AddPrior(id(prior.node), data).status();
  }
  return status;
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;
template class Optimizer<YawPose>::Impl;

}  // namespace hpgo
