#include "hpgo/chains/condensed_graph.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/factor_term.h"
#include "ceres_costs/whitening.h"

namespace hpgo {

template <typename G>
CondensedGraph<G>::CondensedGraph(const HierarchyOptions& options, bool condense)
    : hierarchy_(options), condense_(condense), spans_(options.convention) {
  hierarchy_.SetRefresh([this](Index edge, const G& T) { return Refresh(edge, T); });
}

template <typename G>
ceres_costs::FactorTerm<G> CondensedGraph<G>::FactorOf(Index e) const {
  const Edge& edge = edges_[e];
  switch (edge.place) {
    case Place::kLevel:
      return hierarchy_.FactorOf(0, edge.at);
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

// Brings the chain behind an edge of level 0 up to date with the pose T of its ends: true if it had
// been bent, and has another term now.
template <typename G>
bool CondensedGraph<G>::Refresh(Index level_edge, const G& T) {
  const Index name = edge_of_level_[level_edge];
  if (name >= 0) return false;
  Chain& chain = chains_[~name];
  // What MissedAt says of the whole chain, from its term: most have not been bent.
  const double bend = BendAt(spans_.Model(chain.root), T);
  const double chi2 = FactorCost(hierarchy_.FactorOf(0, level_edge), false, T);
  if (!(bend * std::sqrt(std::max(chi2, chain.chi2)) > tolerance_)) return false;
  linearized_ += spans_.Settle(chain.root, T, tolerance_);
  BindUnfit();
  SetTerm(&chain, T);
  return true;
}

// The term of a chain's level edge, for T of its ends.
template <typename G>
void CondensedGraph<G>::SetTerm(Chain* chain, const G& T) {
  hierarchy_.SetCondensed(chain->level_edge, TermOfSpan(spans_.Model(chain->root), T));
  NoteChi2(chain);
}

template <typename G>
void CondensedGraph<G>::NoteChi2(Chain* chain) {
  chain->chi2 =
      FactorCost(hierarchy_.FactorOf(0, chain->level_edge), false, spans_.Model(chain->root).T);
}

template <typename G>
void CondensedGraph<G>::SettleAll() {
  for (Chain& chain : chains_) {
    if (!chain.alive || chain.level_edge == kNone) continue;
    const G T = TargetOf(chain);
    spans_.SettleAll(chain.root, T);
    SetTerm(&chain, T);
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
    SetTerm(&chain, poses[chain.node[0]].Between(poses[chain.node[1]]));
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
    chain.is_new = false;
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
  linearized_ += spans_.Settle(chain.root, T, tolerance_);
  EdgeData<G> data;
  data.condensed = true;
  data.term = TermOfSpan(spans_.Model(chain.root), T);
  data.weight = ChainWeight(spans_.Model(chain.root));
  chain.level_edge = hierarchy_.AddEdge(a, b, data);
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
void CondensedGraph<G>::PlaceOnLevel(Index e, const EdgeData<G>& data, bool is_new) {
  Edge& edge = edges_[e];
  const auto level_node = [&](Index n) { return n == kNone ? kNone : nodes_[n].level_node; };
  edge.place = Place::kLevel;
  edge.at = hierarchy_.AddEdge(level_node(edge.node[0]), level_node(edge.node[1]), data);
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
         new_data_.size() * (sizeof(EdgeData<G>) + 48) + loose_.size() * (sizeof(G) + 48);
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
