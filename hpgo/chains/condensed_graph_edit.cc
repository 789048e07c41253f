// The condensed graph: adding, changing and removing. Nodes that must show their own pose until the
// next Restructure are kept at once.

#include <utility>

#include "ceres_costs/whitening.h"
#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

// Whether it says where one end is against the other, in all directions.
template <typename G>
bool CondensedGraph<G>::MeasuresAll(const ceres_costs::RelativePoseTerm<G>& term) {
  return ceres_costs::ClassifyInformation<G::kDof>(term.information.Dense()) ==
         ceres_costs::InformationKind::kPositiveDefinite;
}

template <typename G>
bool CondensedGraph<G>::Binds(const ceres_costs::FactorTerm<G>& factor) {
  return factor.loss != nullptr || factor.custom != nullptr || !MeasuresAll(*factor.term);
}

template <typename G>
void CondensedGraph<G>::Bind(Index e) {
  Edge& edge = edges_[e];
  if (edge.binds) return;
  edge.binds = true;
  for (const Index end : edge.node) {
    ++nodes_[end].binding;
    Touch(end);
  }
}

template <typename G>
bool CondensedGraph<G>::WantsKept(Index n) const {
  const Node& node = nodes_[n];
  return !condense_ || node.held || node.root || node.binding > 0 || node.degree > 2;
}

template <typename G>
void CondensedGraph<G>::Touch(Index n) {
  if (nodes_[n].touched) return;
  nodes_[n].touched = true;
  touched_.push_back(n);
}

template <typename G>
Index CondensedGraph<G>::AddNode(const G& pose) {
  Index n;
  if (free_nodes_.empty()) {
    n = static_cast<Index>(nodes_.size());
    nodes_.push_back(Node());
    if (tracking_) reported_.push_back(G());
  } else {
    n = free_nodes_.back();
    free_nodes_.pop_back();
    const bool touched = nodes_[n].touched;  // its index still waits in the list
    nodes_[n] = Node();
    nodes_[n].touched = touched;
  }
  ++num_nodes_;
  nodes_[n].born = next_born_++;
  nodes_[n].alive = true;
  nodes_[n].loose = true;
  loose_[n] = pose.Normalized();
  Touch(n);
  return n;
}

template <typename G>
void CondensedGraph<G>::Link(Index e) {
  Edge& edge = edges_[e];
  for (int side = 0; side < 2; ++side) {
    const Index end = edge.node[side];
    if (end == kNone) continue;
    Node& node = nodes_[end];
    edge.prev[side] = kNone;
    edge.next[side] = node.first_edge;
    if (node.first_edge != kNone) {
      Edge& head = edges_[node.first_edge];
      head.prev[head.node[1] == end] = e;
    }
    node.first_edge = e;
    ++node.degree;
    node.binding += edge.binds;
    Touch(end);
  }
}

template <typename G>
void CondensedGraph<G>::Unlink(Index e) {
  Edge& edge = edges_[e];
  for (int side = 0; side < 2; ++side) {
    const Index end = edge.node[side];
    if (end == kNone) continue;
    Node& node = nodes_[end];
    if (edge.prev[side] == kNone) {
      node.first_edge = edge.next[side];
    } else {
      Edge& prev = edges_[edge.prev[side]];
      prev.next[prev.node[1] == end] = edge.next[side];
    }
    if (edge.next[side] != kNone) {
      Edge& next = edges_[edge.next[side]];
      next.prev[next.node[1] == end] = edge.prev[side];
    }
    --node.degree;
    node.binding -= edge.binds;
    Touch(end);
  }
}

template <typename G>
Index CondensedGraph<G>::AddEdge(Index i, Index j, const EdgeData<G>& data) {
  Index e;
  std::uint32_t generation = 0;
  if (free_edges_.empty()) {
    e = static_cast<Index>(edges_.size());
    edges_.push_back(Edge());
  } else {
    e = free_edges_.back();
    free_edges_.pop_back();
    generation = edges_[e].generation;
    edges_[e] = Edge();
  }
  Edge& edge = edges_[e];
  edge.generation = generation;
  edge.alive = true;
  edge.node[0] = i;
  edge.node[1] = j;
  // Every loop has an edge that came last, and found edges at both of its ends.
  edge.binds = i == kNone || (nodes_[i].degree > 0 && nodes_[j].degree > 0) ||
               Binds(hierarchy_.FactorOf(data));
  ++num_edges_;
  new_data_.emplace(e, data);
  Link(e);
  return e;
}

// Takes an edge out of its chain: both of its ends are kept.
template <typename G>
void CondensedGraph<G>::DropChainOf(Index e) {
  const Edge& edge = edges_[e];
  Keep(edge.node[0]);
  Keep(edge.node[1]);
  const Index c = ChainOf(e);  // of this edge alone now
  DropLevelEdge(c);
  spans_.FreeTree(chains_[c].root);
  spans_.FreeEdge(edge.at);
  FreeChain(c);
}

template <typename G>
void CondensedGraph<G>::RemoveEdge(Index e) {
  Edge& edge = edges_[e];
  switch (edge.place) {
    case Place::kNew:
      new_data_.erase(e);
      break;
    case Place::kLevel:
      pulled_.erase(e);
      hierarchy_.RemoveEdge(edge.at);
      break;
    case Place::kChain:
      DropChainOf(e);
      break;
  }
  Unlink(e);
  edge.alive = false;
  ++edge.generation;
  free_edges_.push_back(e);
  --num_edges_;
}

template <typename G>
void CondensedGraph<G>::RemoveNode(Index n) {
  while (nodes_[n].first_edge != kNone) RemoveEdge(nodes_[n].first_edge);
  Node& node = nodes_[n];
  if (node.level_node != kNone) hierarchy_.RemoveNode(node.level_node);
  if (node.loose) loose_.erase(n);
  node.alive = false;
  node.level_node = kNone;
  free_nodes_.push_back(n);
  --num_nodes_;
}

template <typename G>
void CondensedGraph<G>::UpdateEdge(Index e, const ceres_costs::RelativePoseTerm<G>& term) {
  Edge& edge = edges_[e];
  if (!edge.binds && !MeasuresAll(term)) {
    Bind(e);
    if (edge.place == Place::kChain) {
      for (const Index end : edge.node) Keep(end);
    }
  }
  switch (edge.place) {
    case Place::kNew:
      new_data_.at(e).term = term;
      break;
    case Place::kLevel:
      pulled_.erase(e);
      hierarchy_.UpdateEdge(edge.at, term, edge.node[0] == kNone ? 0 : ModularityWeight(term));
      break;
    case Place::kChain: {
      const Index c = ChainOf(e);
      spans_.SetTerm(edge.at, term);
      DropLevelEdge(c);
      chains_[c].is_new = true;
      chains_[c].composed = false;
      MarkChanged(c);
      break;
    }
  }
}

template <typename G>
void CondensedGraph<G>::SetLoss(Index e, std::shared_ptr<const ceres::LossFunction> loss) {
  Edge& edge = edges_[e];
  if (edge.place == Place::kChain) {
    if (loss == nullptr) return;
    EdgeData<G> data;
    data.term = *FactorOf(e).term;
    data.weight = ModularityWeight(data.term);
    DropChainOf(e);
    edge.place = Place::kNew;
    edge.at = kNone;
    new_data_.emplace(e, data);
  }
  if (loss != nullptr && edge.node[0] != kNone) Bind(e);
  if (edge.place == Place::kNew) {
    new_data_.at(e).loss = std::move(loss);
  } else {
    EndPull(e);
    hierarchy_.SetLoss(edge.at, std::move(loss));
  }
}

template <typename G>
void CondensedGraph<G>::SetHeld(Index n, bool held) {
  Node& node = nodes_[n];
  if (node.held == held) return;
  node.held = held;
  node.root = false;
  if (held) {
    Keep(n);
    hierarchy_.SetFixed(node.level_node, true);
  } else {
    hierarchy_.SetFixed(node.level_node, false);
  }
  Touch(n);
}

template <typename G>
void CondensedGraph<G>::SetWorldPose(Index n, const G& pose) {
  if (nodes_[n].loose) {
    loose_[n] = pose.Normalized();
    return;
  }
  Keep(n);
  Touch(n);
  hierarchy_.SetWorldPose(0, nodes_[n].level_node, pose);
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
