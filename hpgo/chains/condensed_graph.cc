#include "hpgo/chains/condensed_graph.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/factor_term.h"
#include "ceres_costs/whitening.h"

namespace hpgo {

template <typename G>
CondensedGraph<G>::CondensedGraph(const HierarchyOptions& options, bool condense)
    : hierarchy_(options), condense_(condense), spans_(options.convention) {
  hierarchy_.SetChains({[this](Index edge, const G& T) { return Refresh(edge, T); },
                        [this](Index edge, const G& T) { return CostOfChain(edge, T); },
                        [this](ChainTrial trial) { Try(trial); }});
}

template <typename G>
ceres_costs::FactorTerm<G> CondensedGraph<G>::FactorOf(Index e) const {
  const Edge& edge = edges_[e];
  switch (edge.place) {
    case Place::kLevel: {
      ceres_costs::FactorTerm<G> factor = hierarchy_.FactorOf(0, edge.at);
      const auto pulled = pulled_.find(e);
      if (pulled != pulled_.end()) factor.term = &pulled->second.measured;
      return factor;
    }
    case Place::kNew:
      return hierarchy_.FactorOf(new_data_.at(e));
    case Place::kChain:
      break;
  }
  ceres_costs::FactorTerm<G> factor;
  factor.term = &spans_.edge(edge.at).term;
  factor.convention = hierarchy_.options().convention;
  return factor;
}

template <typename G>
Index CondensedGraph<G>::EdgeOfLevel(Index level_edge) const {
  const Index edge = edge_of_level_[level_edge];
  return edge >= 0 ? edge : kNone;
}

template <typename G>
Index CondensedGraph<G>::LevelEdgeOf(Index e) const {
  const Edge& edge = edges_[e];
  if (edge.place == Place::kNew) return kNone;
  return edge.place == Place::kLevel ? edge.at : chains_[ChainOf(e)].level_edge;
}

template <typename G>
Index CondensedGraph<G>::KeptNear(Index n) const {
  if (IsKept(n)) return n;
  const Index c = ChainOfNode(n);
  if (c == kNone) return kNone;
  return chains_[c].node[IsKept(chains_[c].node[0]) ? 0 : 1];
}

// They are kept out of chains from the next Restructure on.
template <typename G>
void CondensedGraph<G>::BindUnfit() {
  for (const Index e : spans_.TakeUnfit()) Bind(e);
}

template <typename G>
void CondensedGraph<G>::SetLags(Chain* chain, bool lags) {
  if (chain->level_edge != kNone) hierarchy_.mutable_level(0).edges[chain->level_edge].lags = lags;
  if (std::exchange(chain->lags, lags) != lags) NoteReach(*chain, true);
}

// So that nothing moves where it is cut, or where it begins to lag.
template <typename G>
void CondensedGraph<G>::LinearizeWhereItIs(Chain* chain, const G& T) {
  if (chain->lags && IsLinearizedAt(spans_.Model(chain->root), T)) return;
  std::vector<G> poses;
  spans_.ForEachEdge(chain->root, T, InsideOf(*chain),
                     [&](Index, const G& Y) { poses.push_back(Y); });
  if (is_trial_) spans_.Remember(chain->root, &trial_log_);
  std::size_t k = 0;
  spans_.LinearizeAt(chain->root, [&](const ChainEdge<G>&) { return poses[k++]; });
}

// False if it lags: where it was, then.
template <typename G>
bool CondensedGraph<G>::Settle(Chain* chain, const G& T) {
  const SettleResult settled =
      spans_.Settle(chain->root, T, tolerance_, chain->lags, is_trial_ ? &trial_log_ : nullptr);
  visited_ += settled.edges;
  if (!settled.holds && !chain->lags) LinearizeWhereItIs(chain, T);
  return settled.holds;
}

// By the term of a chain.
template <typename G>
double CondensedGraph<G>::ChiSquareAt(const Chain& chain, const G& T) const {
  return FactorCost(hierarchy_.FactorOf(0, chain.level_edge), false, T);
}

// What MissedAt says of a whole chain, from its term: most have not been bent.
template <typename G>
bool CondensedGraph<G>::Misses(const Chain& chain, double bend, double chi2) const {
  return bend * std::sqrt(std::max(chi2, chain.chi2)) > tolerance_;
}

// Brings the chain behind an edge of level 0 up to date with the pose T of its ends, where it has
// been bent.
template <typename G>
RefreshedChain CondensedGraph<G>::Refresh(Index level_edge, const G& T) {
  const Index name = edge_of_level_[level_edge];
  if (name >= 0) return RefreshedChain::kHolds;
  Chain& chain = chains_[~name];
  if (!chain.lags && !Misses(chain, BendAt(spans_.Model(chain.root), T), ChiSquareAt(chain, T))) {
    return RefreshedChain::kHolds;
  }
  if (is_trial_) {
    before_trial_.push_back(
        {~name, chain.lags, chain.chi2, *hierarchy_.FactorOf(0, level_edge).term});
  }
  const bool holds = Settle(&chain, T);
  BindUnfit();
  SetLags(&chain, !holds);
  if (!holds) return RefreshedChain::kLags;
  SetTerm(&chain, T);
  return RefreshedChain::kAnew;
}

// Of a trial: what has been tried is forgotten, or the chains that were refreshed by it are put
// back to where they were. Those that could not follow are to be cut all the same.
template <typename G>
void CondensedGraph<G>::Try(ChainTrial trial) {
  if (trial == ChainTrial::kPutBack) {
    spans_.PutBack(LogMark(), &trial_log_);
    for (auto before = before_trial_.rbegin(); before != before_trial_.rend(); ++before) {
      Chain& chain = chains_[before->chain];
      hierarchy_.SetCondensed(chain.level_edge, before->term);
      SetLags(&chain, before->lags);
      chain.chi2 = before->chi2;
    }
  }
  before_trial_.clear();
  trial_log_ = {};
  is_trial_ = trial != ChainTrial::kEnd;
}

// The cost of a chain, for T of its ends: that of its edges where its term says little of them.
template <typename G>
double CondensedGraph<G>::CostOfChain(Index level_edge, const G& T) {
  const Chain& chain = chains_[~edge_of_level_[level_edge]];
  if (!chain.lags) {
    const double bend = BendAt(spans_.Model(chain.root), T), chi2 = ChiSquareAt(chain, T);
    if (!(bend > kFarOnTheWay && Misses(chain, bend, chi2))) return chi2;
  }
  return spans_.CostAt(chain.root, T, InsideOf(chain), &visited_);
}

// The term of a chain's level edge, for T of its ends.
template <typename G>
void CondensedGraph<G>::SetTerm(Chain* chain, const G& T) {
  hierarchy_.SetCondensed(chain->level_edge, TermOfSpan(spans_.Model(chain->root), T));
  NoteChi2(chain);
}

template <typename G>
void CondensedGraph<G>::NoteChi2(Chain* chain) {
  chain->chi2 = ChiSquareAt(*chain, spans_.Model(chain->root).T);
}

template <typename G>
void CondensedGraph<G>::SettleAll() {
  for (Chain& chain : chains_) {
    if (!chain.alive || chain.level_edge == kNone) continue;
    const G T = TargetOf(chain);
    const bool holds = spans_.SettleAll(chain.root, T, chain.lags).holds;
    if (!holds && !chain.lags) LinearizeWhereItIs(&chain, T);
    SetLags(&chain, !holds);
    if (!chain.lags) SetTerm(&chain, T);
  }
  BindUnfit();
}

template <typename G>
void CondensedGraph<G>::LinearizeChainsAt(const std::vector<G>& poses) {
  for (Chain& chain : chains_) {
    if (!chain.alive || chain.level_edge == kNone) continue;
    spans_.LinearizeAt(chain.root, [&](const ChainEdge<G>& part) {
      const Edge& edge = edges_[part.edge];
      return poses[edge.node[part.reversed]].Between(poses[edge.node[!part.reversed]]);
    });
    const G T = poses[chain.node[0]].Between(poses[chain.node[1]]);
    SetLags(&chain, !spans_.FitsTerm(chain.root, T));
    SetTerm(&chain, T);
  }
  BindUnfit();
}

// The level edge of a chain between kept nodes, or of its only edge.
template <typename G>
void CondensedGraph<G>::FinishChain(Index c) {
  Chain& chain = chains_[c];
  if (!IsEnd(chain, 0) || !IsEnd(chain, 1)) {
    const bool grown = chain.composed;
    if (!grown) ComposeFreeEnd(&chain);
    spans_.PrepareFirst(chain.root);
    chain.is_new = chain.lags = false;
    NoteReach(chain, !grown);
    return;
  }
  const bool is_new = chain.is_new;
  if (spans_.IsSingle(chain.root)) {
    const Index at = spans_.FirstEdge(chain.root);
    EdgeData<G> data;
    data.term = spans_.edge(at).term;
    data.weight = ModularityWeight(data.term);
    const Index edge = spans_.edge(at).edge;
    spans_.FreeTree(chain.root);
    spans_.FreeEdge(at);
    FreeChain(c);
    PlaceOnLevel(edge, data, is_new);
    return;
  }
  const Index a = nodes_[chain.node[0]].level_node, b = nodes_[chain.node[1]].level_node;
  const G T = hierarchy_.RelativePose(0, a, b);
  const bool holds = Settle(&chain, T);
  EdgeData<G> data;
  data.condensed = true;
  data.term = TermOfSpan(spans_.Model(chain.root), T);
  data.weight = ChainWeight(spans_.Model(chain.root));
  chain.level_edge = hierarchy_.AddEdge(a, b, data);
  SetLags(&chain, !holds);
  NoteChi2(&chain);
  chain.is_new = false;
  while (static_cast<Index>(edge_of_level_.size()) <= chain.level_edge) {
    edge_of_level_.push_back(kNone);
  }
  edge_of_level_[chain.level_edge] = ~c;
  placed_.push_back({chain.level_edge, is_new});
  chain.length = spans_.Model(chain.root).length;
  NoteReach(chain, true);
}

template <typename G>
void CondensedGraph<G>::PlaceOnLevel(Index e, EdgeData<G> data, bool is_new) {
  Edge& edge = edges_[e];
  const auto level_node = [&](Index n) { return n == kNone ? kNone : nodes_[n].level_node; };
  const Index a = level_node(edge.node[0]), b = level_node(edge.node[1]);
  // A group moves rigidly, and no level above sees what is inside: it must not be what is turned
  // further than windows down here reach.
  if (condense_ && a != kNone &&
      IsTwisted(data.term.measurement, hierarchy_.RelativePose(0, a, b))) {
    data.weight = 0;
  }
  edge.place = Place::kLevel;
  edge.at = hierarchy_.AddEdge(a, b, data);
  while (static_cast<Index>(edge_of_level_.size()) <= edge.at) edge_of_level_.push_back(kNone);
  edge_of_level_[edge.at] = e;
  placed_.push_back({edge.at, is_new});
}

template <typename G>
std::size_t CondensedGraph<G>::MemoryBytes() const {
  return hierarchy_.MemoryBytes() + spans_.MemoryBytes() + nodes_.MemoryBytes() +
         edges_.MemoryBytes() + node_of_level_.MemoryBytes() + edge_of_level_.MemoryBytes() +
         chains_.capacity() * sizeof(Chain) + reported_.MemoryBytes() +
         (free_nodes_.capacity() + free_edges_.capacity() + free_chains_.capacity() +
          touched_.capacity() + changed_.capacity()) *
             sizeof(Index) +
         pulled_.size() * (sizeof(PulledEdge<G>) + 48) +
         new_data_.size() * (sizeof(EdgeData<G>) + 48) + loose_.size() * (sizeof(G) + 48);
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
