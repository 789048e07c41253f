#include "hpgo/hierarchy/hierarchy.h"

#include <algorithm>
#include <cmath>

#include "glog/logging.h"
#include "hpgo/hierarchy/coarse_edge.h"
#include "hpgo/hierarchy/grouping.h"

namespace hpgo {

template <typename G>
double ModularityWeight(const ceres_costs::RelativePoseTerm<G>& term) {
  const typename G::Tangent z = term.measurement.Log();
  return 1 / std::max(z.dot(term.information.Dense() * z), 1e-6);
}

template <typename G>
Hierarchy<G>::Hierarchy(const HierarchyOptions& options) : options_(options) {
  CHECK_GE(options.max_group_size, 2);
  CHECK_GE(options.max_top_nodes, 2);
  CHECK_GE(options.max_top_edges, 1);
  levels_.push_back(std::make_unique<Level<G>>());
}

template <typename G>
Index Hierarchy<G>::AddNode(const G& pose) {
  const Index node = NewNode(0, pose);
  if (num_levels() > 1) unassigned_.push_back({0, node});
  return node;
}

template <typename G>
Index Hierarchy<G>::AddEdge(Index i, Index j, const EdgeData<G>& data) {
  const Index e = LinkEdge(0, i, j, data.weight);
  Level<G>& level = *levels_[0];
  LevelEdge& edge = level.edges[e];
  level.terms[e] = data.term;
  edge.merged = false;  // new, until the scheduler has seen it
  edge.condensed = data.condensed;
  if (data.loss != nullptr || data.custom != nullptr || data.offset != nullptr) {
    edge.extra = NewExtra({data.loss, data.custom, data.offset});
  }
  Lift(0, e);
  RetryIfAlone(0, i);
  RetryIfAlone(0, j);
  return e;
}

template <typename G>
void Hierarchy<G>::RemoveEdge(Index edge) {
  EraseEdge(0, edge);
  RepairGroups();
}

template <typename G>
void Hierarchy<G>::RemoveNode(Index node) {
  if (levels_[0]->nodes[node].fixed > 0) AddFixed(0, node, -1);
  while (levels_[0]->nodes[node].first_edge != kNone) {
    EraseEdge(0, levels_[0]->nodes[node].first_edge);
  }
  DetachAndForget(0, node);
  RepairGroups();
}

template <typename G>
void Hierarchy<G>::UpdateEdge(Index edge, const ceres_costs::RelativePoseTerm<G>& term,
                              double weight) {
  const LevelEdge& record = levels_[0]->edges[edge];
  levels_[0]->terms[edge] = term;
  AddWeight(0, edge, weight - record.weight);
  MarkAncestorsDirty(0, edge);
}

template <typename G>
void Hierarchy<G>::SetLoss(Index edge, std::shared_ptr<const ceres::LossFunction> loss) {
  LevelEdge& record = levels_[0]->edges[edge];
  if (record.extra == kNone && loss == nullptr) return;
  if (record.extra == kNone) record.extra = NewExtra({});
  extras_[record.extra].loss = std::move(loss);
  MarkAncestorsDirty(0, edge);
}

template <typename G>
void Hierarchy<G>::AssignGroups() {
  for (std::size_t k = 0; k < unassigned_.size(); ++k) {
    const LevelItem item = unassigned_[k];
    if (item.l + 1 >= num_levels()) continue;
    const LevelNode<G>& node = levels_[item.l]->nodes[item.index];
    if (node.alive) AssignGroup(item.l, item.index);
  }
  unassigned_.clear();
  if (!suspects_.empty()) RepairGroups();
  // Components cannot be grouped together: where they are many the top stays large, and is tried
  // again only when it has changed by some.
  const auto size_of_top = [this] { return levels_.back()->num_nodes + levels_.back()->num_edges; };
  if (2 * size_of_top() < next_new_level_) next_new_level_ = 0;
  while (IsTooLarge(num_levels() - 1) && size_of_top() >= next_new_level_) {
    const Index before = levels_.back()->num_nodes;
    AddLevel();
    next_new_level_ = 0;
    if (4 * levels_.back()->num_nodes <= 3 * before) continue;
    DropTop();
    next_new_level_ = size_of_top() + size_of_top() / 8 + 1;
  }
}

template <typename G>
void Hierarchy<G>::SetFixed(Index node, bool fixed) {
  const bool is_fixed = levels_[0]->nodes[node].fixed > 0;
  if (fixed != is_fixed) AddFixed(0, node, fixed ? 1 : -1);
}

template <typename G>
G Hierarchy<G>::WorldPose(int l, Index node) const {
  const LevelNode<G>* record = &levels_[l]->nodes[node];
  G pose = record->pose;
  while (record->parent != kNone) {
    record = &levels_[++l]->nodes[record->parent];
    pose = record->pose * pose;
  }
  return pose;
}

template <typename G>
G Hierarchy<G>::RelativePose(int l, Index a, Index b) const {
  if (a == kNone) return WorldPose(l, b);
  const LevelNode<G>*node_a = &levels_[l]->nodes[a], *node_b = &levels_[l]->nodes[b];
  G pose_a = node_a->pose, pose_b = node_b->pose;
  while (node_a->parent != node_b->parent) {
    if (node_a->parent == kNone || node_b->parent == kNone) {
      return WorldPose(l, a).Between(WorldPose(l, b));
    }
    ++l;
    node_a = &levels_[l]->nodes[a = node_a->parent];
    node_b = &levels_[l]->nodes[b = node_b->parent];
    pose_a = node_a->pose * pose_a;
    pose_b = node_b->pose * pose_b;
  }
  return pose_a.Between(pose_b);
}

template <typename G>
void Hierarchy<G>::SetWorldPose(int l, Index node, const G& pose) {
  const Index parent = levels_[l]->nodes[node].parent;
  SetLocalPose(l, node, parent == kNone ? pose : WorldPose(l + 1, parent).Between(pose));
}

template <typename G>
void Hierarchy<G>::SetLocalPose(int l, Index node, const G& pose) {
  LevelNode<G>& record = levels_[l]->nodes[node];
  const G before = record.pose;
  record.pose = pose.Normalized();
  if (tracking_) NoteMove(l, node, before);
}

template <typename G>
Index Hierarchy<G>::Ancestor(Index node, int l) const {
  for (int k = 0; k < l && node != kNone; ++k) node = levels_[k]->nodes[node].parent;
  return node;
}

template <typename G>
ceres_costs::FactorTerm<G> Hierarchy<G>::FactorOf(int l, Index edge) const {
  const LevelEdge& record = levels_[l]->edges[edge];
  ceres_costs::FactorTerm<G> factor;
  factor.term = &levels_[l]->terms[edge];
  if (l > 0 || record.condensed) {
    factor.convention = kCoarseConvention;
    return factor;
  }
  factor.convention = options_.convention;
  if (record.extra != kNone) {
    const Extra& extra = extras_[record.extra];
    factor.loss = extra.loss.get();
    factor.offset = extra.offset.get();
    factor.custom = extra.custom.get();
  }
  return factor;
}

template <typename G>
ceres_costs::FactorTerm<G> Hierarchy<G>::FactorOf(const EdgeData<G>& data) const {
  ceres_costs::FactorTerm<G> factor;
  factor.term = &data.term;
  factor.convention = data.condensed ? kCoarseConvention : options_.convention;
  factor.loss = data.loss.get();
  factor.offset = data.offset.get();
  factor.custom = data.custom.get();
  return factor;
}

template <typename G>
bool Hierarchy<G>::RefreshChain(Index edge, const G& T) {
  const ceres_costs::RelativePoseTerm<G> old = levels_[0]->terms[edge];
  const RefreshedChain refreshed = chains_.refresh(edge, T);
  if (refreshed != RefreshedChain::kAnew) return refreshed == RefreshedChain::kLags;
  CoarseEdge<G> now;
  now.T_g_h = T;
  LinearizeFactor(FactorOf(0, edge), false, T, &now.model);
  now.inverse = SemiDefiniteInverse<G>(now.model.A);
  refreshed_.emplace_back(edge, QuadraticChange(now, &old));
  return true;
}

template <typename G>
double Hierarchy<G>::CostAt(Index edge, const G& T) const {
  const LevelEdge& record = levels_[0]->edges[edge];
  if (record.condensed && chains_.cost) return chains_.cost(edge, T);
  return FactorCost(FactorOf(0, edge), record.node[0] == kNone, T);
}

template <typename G>
double Hierarchy<G>::Merge(int l, Index edge) {
  LevelEdge& record = levels_[l]->edges[edge];
  if (l == 1 && chains_.refresh) {
    const G T_g_h = RelativePose(l, record.node[0], record.node[1]);
    for (Index c = record.first_child; c != kNone; c = levels_[0]->edges[c].next_sibling) {
      const LevelEdge& child = levels_[0]->edges[c];
      if (!child.condensed) continue;
      RefreshChain(c, ChildGeometry<G>(record, child, *levels_[0], T_g_h).RelativePose());
    }
  }
  const bool galerkin = options_.coarse_edges == CoarseEdges::kGalerkin;
  const CoarseEdge<G> merged =
      galerkin ? GalerkinEdge(*this, l, edge) : CondensedEdge(*this, l, edge);
  const double change = QuadraticChange(merged, record.merged ? &levels_[l]->terms[edge] : nullptr);
  levels_[l]->terms[edge] = merged.term;
  record.chi2 = static_cast<float>(merged.model.cost);
  if (l > 1) {
    record.chi2 = 0;
    for (Index c = record.first_child; c != kNone; c = levels_[l - 1]->edges[c].next_sibling) {
      record.chi2 += levels_[l - 1]->edges[c].chi2;
    }
  }
  record.merged = true;
  record.centred = false;
  record.changed = 0;
  return change;
}

template <typename G>
double Hierarchy<G>::CostDecrease(int l, Index edge, const G& before, const G& after,
                                  int* budget) const {
  const LevelEdge& record = levels_[l]->edges[edge];
  if (l == 0) return CostAt(edge, before) - CostAt(edge, after);
  if (*budget < record.num_children) {
    const bool unary = record.node[0] == kNone;
    const ceres_costs::FactorTerm<G> factor = FactorOf(l, edge);
    return FactorCost(factor, unary, before) - FactorCost(factor, unary, after);
  }
  *budget -= record.num_children;
  const Level<G>& below = *levels_[l - 1];
  double decrease = 0;
  for (Index c = record.first_child; c != kNone; c = below.edges[c].next_sibling) {
    const LevelEdge& child = below.edges[c];
    decrease +=
        CostDecrease(l - 1, c, ChildGeometry<G>(record, child, below, before).RelativePose(),
                     ChildGeometry<G>(record, child, below, after).RelativePose(), budget);
  }
  return decrease;
}

template <typename G>
void Hierarchy<G>::MarkDirty(int l, Index edge) {
  LevelEdge& record = levels_[l]->edges[edge];
  record.centred = false;  // the estimate does not hold the change yet
  if (record.dirty) return;
  record.dirty = true;
  levels_[l]->dirty.push_back(edge);
}

template <typename G>
void Hierarchy<G>::SetPending(int l, Index edge, float pending, float threshold) {
  DCHECK_GE(pending, 0) << "level " << l << ", edge " << edge;  // a NaN would never be looked at
  Level<G>& level = *levels_[l];
  level.pending.Update(edge, pending, threshold, level.edges);
}

template <typename G>
std::size_t Hierarchy<G>::MemoryBytes() const {
  std::size_t bytes =
      extras_.MemoryBytes() + free_extras_.capacity() * sizeof(Index) + reported_.MemoryBytes();
  for (const auto& level : levels_) {
    bytes += sizeof(Level<G>) + level->nodes.MemoryBytes() + level->edges.MemoryBytes() +
             level->terms.MemoryBytes();
    bytes += sizeof(Index) * (level->free_nodes.capacity() + level->free_edges.capacity() +
                              level->dirty.capacity());
  }
  return bytes;
}

template double ModularityWeight(const ceres_costs::RelativePoseTerm<ceres_costs::SE2>&);
template double ModularityWeight(const ceres_costs::RelativePoseTerm<ceres_costs::SE3>&);
template double ModularityWeight(const ceres_costs::RelativePoseTerm<ceres_costs::YawPose>&);
template class Hierarchy<ceres_costs::SE2>;
template class Hierarchy<ceres_costs::SE3>;
template class Hierarchy<ceres_costs::YawPose>;

}  // namespace hpgo
