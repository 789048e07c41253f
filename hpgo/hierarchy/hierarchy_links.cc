// The links of the hierarchy: adjacency, and edges lifted to the levels above.

#include <algorithm>
#include <limits>
#include <utility>

#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/hierarchy/siblings.h"

namespace hpgo {

template <typename G>
Index Hierarchy<G>::NewNode(int l, const G& pose) {
  Level<G>& level = *levels_[l];
  Index node;
  if (level.free_nodes.empty()) {
    node = static_cast<Index>(level.nodes.size());
    level.nodes.push_back(LevelNode<G>());
  } else {
    node = level.free_nodes.back();
    level.free_nodes.pop_back();
    level.nodes[node] = LevelNode<G>();
  }
  level.nodes[node].pose = pose.Normalized();
  level.nodes[node].alive = true;
  ++level.num_nodes;
  if (tracking_ && l == 0) {  // new: to be visited whatever the limits
    while (static_cast<Index>(reported_.size()) <= node) reported_.push_back(G());
    level.nodes[node].moved.distance = std::numeric_limits<float>::infinity();
  }
  return node;
}

template <typename G>
void Hierarchy<G>::FreeNode(int l, Index node) {
  Level<G>& level = *levels_[l];
  level.nodes[node].alive = false;
  level.free_nodes.push_back(node);
  --level.num_nodes;
}

template <typename G>
Index Hierarchy<G>::LinkEdge(int l, Index i, Index j, double weight) {
  Level<G>& level = *levels_[l];
  Index e;
  if (level.free_edges.empty()) {
    e = static_cast<Index>(level.edges.size());
    level.edges.push_back(LevelEdge());
    level.terms.push_back({});
  } else {
    e = level.free_edges.back();
    level.free_edges.pop_back();
    const LevelEdge& old = level.edges[e];
    LevelEdge fresh;
    fresh.generation = old.generation;
    fresh.dirty = old.dirty;  // its index still waits in the list
    level.edges[e] = fresh;
  }
  LevelEdge& edge = level.edges[e];
  edge.alive = true;
  ++level.num_edges;
  const Index ends[2] = {i, j};
  for (int side = 0; side < 2; ++side) {
    const Index end = edge.node[side] = ends[side];
    if (end == kNone) continue;
    LevelNode<G>& node = level.nodes[end];
    edge.next[side] = node.first_edge;
    if (node.first_edge != kNone) {
      LevelEdge& head = level.edges[node.first_edge];
      head.prev[head.node[1] == end] = e;
    }
    node.first_edge = e;
    ++node.degree;
  }
  AddWeight(l, e, weight);
  return e;
}

template <typename G>
Index Hierarchy<G>::NewExtra(Extra extra) {
  Index at;
  if (free_extras_.empty()) {
    at = static_cast<Index>(extras_.size());
    extras_.push_back(Extra());
  } else {
    at = free_extras_.back();
    free_extras_.pop_back();
  }
  extras_[at] = std::move(extra);
  return at;
}

template <typename G>
void Hierarchy<G>::UnlinkEdge(int l, Index e) {
  Level<G>& level = *levels_[l];
  LevelEdge& edge = level.edges[e];
  for (int side = 0; side < 2; ++side) {
    const Index end = edge.node[side];
    if (end == kNone) continue;
    LevelNode<G>& node = level.nodes[end];
    if (edge.prev[side] == kNone) {
      node.first_edge = edge.next[side];
    } else {
      LevelEdge& prev = level.edges[edge.prev[side]];
      prev.next[prev.node[1] == end] = edge.next[side];
    }
    if (edge.next[side] != kNone) {
      LevelEdge& next = level.edges[edge.next[side]];
      next.prev[next.node[1] == end] = edge.prev[side];
    }
    if (--node.degree == 0) node.weight = 0;  // sheds the rounding
  }
  edge.alive = false;
  ++edge.generation;
  level.free_edges.push_back(e);
  --level.num_edges;
}

template <typename G>
void Hierarchy<G>::AddWeight(int l, Index e, double delta) {
  if (delta == 0) return;
  for (; e != kNone; e = levels_[l++]->edges[e].parent) {
    Level<G>& level = *levels_[l];
    LevelEdge& edge = level.edges[e];
    edge.weight += delta;
    level.total_weight += delta;
    for (const Index end : edge.node) {
      if (end != kNone) level.nodes[end].weight += delta;
    }
  }
}

template <typename G>
Index Hierarchy<G>::FindEdge(int l, Index i, Index j) const {
  const Level<G>& level = *levels_[l];
  if (i != kNone && level.nodes[i].degree < level.nodes[j].degree) std::swap(i, j);
  for (Index e = level.nodes[j].first_edge; e != kNone;) {
    const LevelEdge& edge = level.edges[e];
    const int side = edge.node[1] == j;
    if (edge.node[1 - side] == i) return e;
    e = edge.next[side];
  }
  return kNone;
}

template <typename G>
void Hierarchy<G>::Lift(int l, Index e) {
  if (l + 1 >= num_levels()) return;
  LevelEdge& edge = levels_[l]->edges[e];
  const Level<G>& level = *levels_[l];
  const Index p = edge.node[0] == kNone ? kNone : level.nodes[edge.node[0]].parent;
  const Index q = level.nodes[edge.node[1]].parent;
  if (q == kNone || (p == kNone && edge.node[0] != kNone) || p == q) return;
  Index f = FindEdge(l + 1, p, q);
  if (f == kNone) {
    f = LinkEdge(l + 1, p, q, 0);
    Lift(l + 1, f);
    RetryIfAlone(l + 1, p);
    RetryIfAlone(l + 1, q);
  }
  LevelEdge& parent = levels_[l + 1]->edges[f];
  edge.parent = f;
  LinkSibling(e, &parent.first_child, &levels_[l]->edges);
  ++parent.num_children;
  AddWeight(l + 1, f, edge.weight);
  MarkAncestorsDirty(l, e);
}

template <typename G>
void Hierarchy<G>::Unlift(int l, Index e) {
  LevelEdge& edge = levels_[l]->edges[e];
  const Index f = edge.parent;
  if (f == kNone) return;
  LevelEdge& parent = levels_[l + 1]->edges[f];
  UnlinkSibling(e, &parent.first_child, &levels_[l]->edges);
  edge.parent = kNone;
  --parent.num_children;
  AddWeight(l + 1, f, -edge.weight);
  if (parent.num_children == 0) {
    EraseEdge(l + 1, f);
    return;
  }
  MarkDirty(l + 1, f);
  MarkAncestorsDirty(l + 1, f);
}

template <typename G>
void Hierarchy<G>::EraseEdge(int l, Index e) {
  Level<G>& level = *levels_[l];
  LevelEdge& edge = level.edges[e];
  Unlift(l, e);
  if (edge.node[0] != kNone) {
    const Index p = level.nodes[edge.node[0]].parent;
    if (p != kNone && p == level.nodes[edge.node[1]].parent) suspects_.push_back({l + 1, p});
  }
  AddWeight(l, e, -edge.weight);
  if (edge.queued) level.pending.Erase(e, level.edges);
  if (edge.extra != kNone) {
    extras_[edge.extra] = Extra();
    free_extras_.push_back(edge.extra);
    edge.extra = kNone;
  }
  UnlinkEdge(l, e);
}

// All of them: they gain or lose information even where no gradient changes.
template <typename G>
void Hierarchy<G>::MarkAncestorsDirty(int l, Index e) {
  for (Index f = levels_[l]->edges[e].parent; f != kNone; f = levels_[l]->edges[f].parent) {
    MarkDirty(++l, f);
  }
}

template <typename G>
void Hierarchy<G>::AddFixed(int l, Index node, int delta) {
  for (; node != kNone; node = levels_[l++]->nodes[node].parent) {
    std::int32_t& fixed = levels_[l]->nodes[node].fixed;
    const bool before = fixed > 0;
    fixed += delta;
    if (before == (fixed > 0)) return;
  }
}

template class Hierarchy<ceres_costs::SE2>;
template class Hierarchy<ceres_costs::SE3>;
template class Hierarchy<ceres_costs::YawPose>;

}  // namespace hpgo
