// The condensed graph: which nodes are kept, and what lies between them.

#include <utility>

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

template <typename G>
Index CondensedGraph<G>::NewChain(Index from, Index to, Index root) {
  Index c;
  if (free_chains_.empty()) {
    c = static_cast<Index>(chains_.size());
    chains_.push_back(Chain());
  } else {
    c = free_chains_.back();
    free_chains_.pop_back();
    const bool changed = chains_[c].changed;  // its index still waits in the list
    chains_[c] = Chain();
    chains_[c].changed = changed;
  }
  chains_[c].alive = true;
  chains_[c].node[0] = from;
  chains_[c].node[1] = to;
  chains_[c].root = root;
  spans_.SetOwner(root, c);
  MarkChanged(c);
  return c;
}

template <typename G>
void CondensedGraph<G>::FreeChain(Index c) {
  chains_[c].alive = false;
  free_chains_.push_back(c);
}

template <typename G>
void CondensedGraph<G>::MarkChanged(Index c) {
  if (chains_[c].changed) return;
  chains_[c].changed = true;
  changed_.push_back(c);
}

template <typename G>
void CondensedGraph<G>::DropLevelEdge(Index c) {
  if (chains_[c].level_edge == kNone) return;
  hierarchy_.RemoveEdge(chains_[c].level_edge);
  chains_[c].level_edge = kNone;
}

// Ends the chain that a node is inside of at this node, and begins another.
template <typename G>
void CondensedGraph<G>::CutAt(Index n) {
  Index inside[2] = {kNone, kNone};  // its edges in chains
  int count = 0;
  ForEachEdgeOf(n, [&](Index e, Index) {
    if (edges_[e].place == Place::kChain) inside[count++] = e;
  });
  if (count == 0) return;
  const Index c = ChainOf(inside[0]);
  DropLevelEdge(c);
  MarkChanged(c);
  chains_[c].composed = false;
  if (count == 1) return;  // its free end
  const Index at = edges_[inside[0]].at;
  Index before, after;
  spans_.Split(at, &before, &after);
  const Index single = spans_.NewLeaf(at);
  if (after != kNone && spans_.FirstEdge(after) == edges_[inside[1]].at) {
    before = spans_.Concatenate(before, single);
  } else {
    after = spans_.Concatenate(single, after);
  }
  const Index end = chains_[c].node[1];
  const bool is_new = chains_[c].is_new;
  chains_[c].node[1] = n;
  chains_[c].root = before;
  spans_.SetOwner(before, c);
  const bool lags = chains_[c].lags;
  Chain& rest = chains_[NewChain(n, end, after)];
  rest.is_new = is_new;
  rest.lags = lags;
}

template <typename G>
void CondensedGraph<G>::Keep(Index n) {
  Node& node = nodes_[n];
  if (node.level_node != kNone) return;
  const Index chain = ChainOfNode(n);
  // One that holds an unfit edge is bent too far for its pieces to have the mean that it had.
  bool is_unfit = chain != kNone && chains_[chain].lags;
  ForEachEdgeOf(
      n, [&](Index e, Index) { is_unfit |= edges_[e].binds && edges_[e].place == Place::kChain; });
  if (is_unfit) {
    LinearizeWhereItIs(&chains_[chain], TargetOf(chains_[chain]));
    SetLags(&chains_[chain], true);
  }
  const G pose = WorldPose(n);
  if (node.loose) {
    node.loose = false;
    loose_.erase(n);
  } else {
    CutAt(n);
  }
  node.level_node = hierarchy_.AddNode(pose);
  while (static_cast<Index>(node_of_level_.size()) <= node.level_node) {
    node_of_level_.push_back(kNone);
  }
  node_of_level_[node.level_node] = n;
  if (node.held) hierarchy_.SetFixed(node.level_node, true);
  Touch(n);
}

// A node that need not be kept any more: its edges on level 0 become chains.
template <typename G>
void CondensedGraph<G>::Release(Index n) {
  Node& node = nodes_[n];
  bool last = node.degree > 0;  // the only kept node of its component
  ForEachEdgeOf(n, [&](Index e, Index other) {
    if (edges_[e].place == Place::kChain) {
      const Chain& chain = chains_[ChainOf(e)];
      other = chain.node[chain.node[0] == n];
    }
    last &= edges_[e].place == Place::kNew || !IsKept(other);
  });
  if (last) {
    node.root = true;
    roots_.push_back(n);
    has_new_component_ = true;
    return;
  }
  const Index level_node = std::exchange(node.level_node, kNone);
  const G pose = hierarchy_.WorldPose(0, level_node);
  ForEachEdgeOf(n, [&](Index e, Index) {
    const Edge& edge = edges_[e];
    if (edge.place == Place::kChain) {
      const Index c = ChainOf(e);
      DropLevelEdge(c);
      MarkChanged(c);
      chains_[c].composed = false;
    } else if (edge.place == Place::kLevel) {
      const ceres_costs::RelativePoseTerm<G> term = *hierarchy_.FactorOf(0, edge.at).term;
      hierarchy_.RemoveEdge(edge.at);
      MakeChainOf(e, term, false);
    }
  });
  hierarchy_.RemoveNode(level_node);
  if (node.degree > 0) return;
  node.loose = true;
  loose_[n] = pose;
}

// A chain of one edge, in the direction in which it can be joined to those it meets.
template <typename G>
void CondensedGraph<G>::MakeChainOf(Index e, const ceres_costs::RelativePoseTerm<G>& term,
                                    bool is_new) {
  Edge& edge = edges_[e];
  bool reversed = false;
  for (int side = 0; side < 2; ++side) {
    if (IsKept(edge.node[side])) continue;
    ForEachEdgeOf(edge.node[side], [&](Index other, Index) {
      if (other == e || edges_[other].place != Place::kChain) return;
      // It should end where this one begins.
      reversed = chains_[ChainOf(other)].node[1 - side] != edge.node[side];
    });
  }
  const auto end_loose = [&](Index n) {
    if (!nodes_[n].loose) return;
    nodes_[n].loose = false;
    loose_.erase(n);
  };
  for (const Index n : edge.node) end_loose(n);
  edge.place = Place::kChain;
  edge.at = spans_.AddEdge(term, e, reversed);
  const Index c = NewChain(edge.node[reversed], edge.node[!reversed], spans_.RootOf(edge.at));
  chains_[c].is_new = is_new;
  const G& Y = spans_.edge(edge.at).Y;
  chains_[c].T_kept_free = IsKept(chains_[c].node[0]) ? Y : Y.Inverse();
  chains_[c].length = static_cast<float>(Y.translation().norm());
  chains_[c].composed = true;
}

// Makes one chain of the two that meet at a node.
template <typename G>
void CondensedGraph<G>::JoinAt(Index n) {
  Index met[2] = {kNone, kNone};
  int count = 0;
  ForEachEdgeOf(n, [&](Index e, Index) { met[count++] = ChainOf(e); });
  if (count < 2 || met[0] == met[1]) return;
  Index p = met[0], q = met[1];
  for (const Index c : {p, q}) DropLevelEdge(c);
  const auto reverse = [&](Index c) {
    Chain& chain = chains_[c];
    std::swap(chain.node[0], chain.node[1]);
    chain.root = spans_.Reversed(chain.root);
    spans_.SetOwner(chain.root, c);
  };
  if (chains_[p].node[1] != n) std::swap(p, q);
  // Both end here, or both begin: the shorter turns round.
  if (chains_[p].node[1] != n || chains_[q].node[0] != n) {
    const bool first = spans_.HeightOf(chains_[p].root) < spans_.HeightOf(chains_[q].root);
    reverse(first ? p : q);
    if (chains_[p].node[1] != n) std::swap(p, q);
  }
  Chain &first = chains_[p], &second = chains_[q];
  const bool appended = spans_.IsSingle(second.root);
  const bool prepended = spans_.IsSingle(first.root);
  // Where the other end of one is free, and it is an edge, its pose goes on from what was composed.
  // An edge cut out of a chain is where that had it, not where its measurement is.
  const bool composed = first.composed && second.composed;
  if (IsKept(first.node[0]) && appended) {
    const G& Y = spans_.edge(spans_.FirstEdge(second.root)).Y;
    first.T_kept_free = (first.T_kept_free * Y).Normalized();
    first.length += second.length;
    first.composed = composed;
  } else if (IsKept(second.node[1]) && prepended) {
    const G& Y = spans_.edge(spans_.FirstEdge(first.root)).Y;
    first.composed = composed;
    first.T_kept_free = (second.T_kept_free * Y.Inverse()).Normalized();
    first.length += second.length;
  } else {
    first.composed = false;
  }
  first.root = spans_.Concatenate(first.root, second.root);
  spans_.SetOwner(first.root, p);
  first.node[1] = second.node[1];
  first.is_new |= second.is_new;
  first.lags |= second.lags;
  MarkChanged(p);
  FreeChain(q);
}

template <typename G>
void CondensedGraph<G>::Restructure() {
  placed_.clear();
  has_new_component_ = false;
  for (const Index n : std::exchange(roots_, {})) {
    nodes_[n].root = false;
    Touch(n);
  }
  const std::vector<Index> loose = LooseByAge();
  PoseNewNodes(loose);
  FindRoots(loose);
  const std::vector<Index> touched = touched_;
  // First those that become kept: their poses follow from the ones that are.
  for (const Index n : touched) {
    if (nodes_[n].alive && WantsKept(n)) Keep(n);
  }
  for (const Index n : touched) {
    if (nodes_[n].alive && IsKept(n) && !WantsKept(n)) Release(n);
  }
  for (const auto& [e, data] : new_data_) {
    const Edge& edge = edges_[e];
    if (edge.node[0] == kNone || (IsKept(edge.node[0]) && IsKept(edge.node[1]))) {
      PlaceOnLevel(e, data, true);
    } else {
      MakeChainOf(e, data.term, true);
    }
  }
  new_data_.clear();
  for (const Index n : touched) {
    if (nodes_[n].alive && !IsKept(n) && !nodes_[n].loose && nodes_[n].degree == 2) JoinAt(n);
  }
  const std::vector<Index> changed = std::exchange(changed_, {});
  for (const Index c : changed) {
    chains_[c].changed = false;
    if (chains_[c].alive) FinishChain(c);
  }
  for (const Index n : std::exchange(touched_, {})) {
    nodes_[n].touched = false;
    if (tracking_ && !nodes_[n].reported) unreported_.push_back(n);
  }
  BindUnfit();
  first_new_ = next_born_;
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
