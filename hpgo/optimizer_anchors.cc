// Optimizer: what holds the gauge. Components are found on the top level, which is connected
// exactly as the graph is: groups are connected, and every edge between groups is lifted.

#include <algorithm>
#include <limits>
#include <numeric>

#include "hpgo/optimizer_impl.h"

namespace hpgo {
namespace {

// Holders of a component other than anchors, which are numbered by age: the smaller, the stronger.
constexpr std::int64_t kCaller = -1;
constexpr std::int64_t kNothing = std::numeric_limits<std::int64_t>::max();

}  // namespace

template <typename G>
Index Optimizer<G>::Impl::TopAncestor(Index node) const {
  return hierarchy_.Ancestor(node, hierarchy_.num_levels() - 1);
}

// Whether an edge was there, or has a descendant that was, before the edges added since the last
// update.
template <typename G>
bool Optimizer<G>::Impl::IsOld(int l, Index edge) const {
  const LevelEdge& record = hierarchy_.level(l).edges[edge];
  if (record.merged) return true;
  if (l == 0) return false;
  const Level<G>& below = hierarchy_.level(l - 1);
  for (Index c = record.first_child; c != kNone; c = below.edges[c].next_sibling) {
    if (IsOld(l - 1, c)) return true;
  }
  return false;
}

template <typename G>
typename Optimizer<G>::Impl::TopComponents Optimizer<G>::Impl::FindTopComponents(
    bool old_edges_only) const {
  const int l = hierarchy_.num_levels() - 1;
  const Level<G>& top = hierarchy_.level(l);
  TopComponents components;
  components.of_node.assign(top.nodes.size(), -1);
  std::vector<Index> queue;
  for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
    if (!top.nodes[n].alive || components.of_node[n] >= 0) continue;
    components.of_node[n] = components.count;
    queue.assign(1, n);
    while (!queue.empty()) {
      const Index at = queue.back();
      queue.pop_back();
      ForEachEdge(top, at, [&](Index e, Index other) {
        if (other == kNone || components.of_node[other] >= 0) return;
        if (old_edges_only && !IsOld(l, e)) return;
        components.of_node[other] = components.count;
        queue.push_back(other);
      });
    }
    ++components.count;
  }
  return components;
}

// A new node that no edge ties to an older one begins a component.
template <typename G>
void Optimizer<G>::Impl::FindNewComponents() {
  const std::uint32_t stamp = hierarchy_.NewStamp();
  Level<G>& level = hierarchy_.mutable_level(0);
  for (const Index n : new_nodes_) level.nodes[n].stamp = stamp;
  for (const Index n : new_nodes_) {
    bool tied = false;
    ForEachEdge(level, n, [&](Index, Index other) {
      tied |= other == kNone || level.nodes[other].stamp != stamp;
    });
    check_anchors_ |= !tied;
    level.nodes[n].stamp = 0;  // older than the new nodes after it
  }
}

// Where a new edge joins two components, one of which nothing but its first node holds, that one
// moves as a whole to fit the edge: from far off, no local solve would bring it there. Comes before
// the grouping, which may put nodes of both into one group.
template <typename G>
void Optimizer<G>::Impl::AlignJoinedComponents() {
  if (anchors_.size() + !fixed_.empty() + (num_priors_ > 0) < 2) return;
  const int l = hierarchy_.num_levels() - 1;
  const Level<G>& top = hierarchy_.level(l);
  TopComponents components = FindTopComponents(/*old_edges_only=*/true);
  std::map<Index, int> lone;  // new nodes, of no group yet: each a component
  for (const Index node : new_nodes_) {
    if (TopAncestor(node) == kNone) lone[node] = components.count++;
  }
  const auto component_of = [&](Index node) {
    const Index group = TopAncestor(node);
    return group == kNone ? lone.at(node) : components.of_node[group];
  };
  const std::vector<std::int64_t> holder = FindHolders(components, component_of);
  std::vector<int> merged(components.count);  // component -> what it has been joined to
  std::iota(merged.begin(), merged.end(), 0);
  for (const EdgeId id : new_edges_) {
    const Result<Index> edge = FindEdge(id);
    if (!edge.ok()) continue;
    const LevelEdge& record = hierarchy_.level(0).edges[*edge];
    if (record.node[0] == kNone) continue;
    int side[2];
    for (int s = 0; s < 2; ++s) side[s] = merged[component_of(record.node[s])];
    if (side[0] == side[1]) continue;
    const int weak = holder[side[0]] > holder[side[1]] ? 0 : 1;
    const int moving = side[weak], staying = side[1 - weak];
    if (holder[moving] != kCaller && holder[moving] != kNothing) {
      const G X_i = hierarchy_.WorldPose(0, record.node[0]);
      const G X_j = hierarchy_.WorldPose(0, record.node[1]);
      const G& Z = hierarchy_.level(0).terms[*edge].measurement;
      const G correction = weak == 1 ? X_i * Z * X_j.Inverse() : X_j * Z.Inverse() * X_i.Inverse();
      for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
        if (!top.nodes[n].alive || components.of_node[n] < 0) continue;
        if (merged[components.of_node[n]] != moving) continue;
        hierarchy_.SetWorldPose(l, n, correction * top.nodes[n].pose);
      }
      for (const auto& [node, component] : lone) {
        if (merged[component] != moving) continue;
        hierarchy_.SetWorldPose(0, node, correction * hierarchy_.WorldPose(0, node));
      }
    }
    std::replace(merged.begin(), merged.end(), moving, staying);
  }
}

// By component, what holds it: the caller (a fixed node, a prior), the age of an anchor, nothing.
template <typename G>
std::vector<std::int64_t> Optimizer<G>::Impl::FindHolders(
    const TopComponents& components, const std::function<int(Index)>& component_of) const {
  std::vector<std::int64_t> holder(components.count, kNothing);
  for (const auto& [node, age] : anchors_) {
    std::int64_t& h = holder[component_of(node)];
    h = std::min(h, age);
  }
  for (const Index node : fixed_) holder[component_of(node)] = kCaller;
  if (num_priors_ == 0) return holder;
  const Level<G>& top = hierarchy_.level(hierarchy_.num_levels() - 1);
  for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
    if (!top.nodes[n].alive) continue;
    ForEachEdge(top, n, [&](Index, Index other) {
      if (other == kNone) holder[components.of_node[n]] = kCaller;
    });
  }
  for (const Index node : new_nodes_) {
    ForEachEdge(hierarchy_.level(0), node, [&](Index, Index other) {
      if (other == kNone) holder[component_of(node)] = kCaller;
    });
  }
  return holder;
}

// Gives every component that neither a fixed node nor a prior holds exactly one anchor: the oldest
// it has, else its first node.
template <typename G>
void Optimizer<G>::Impl::HoldComponents() {
  const int l = hierarchy_.num_levels() - 1;
  for (const auto& [node, age] : anchors_) hierarchy_.SetFixed(node, false);
  const Level<G>& top = hierarchy_.level(l);
  const TopComponents components = FindTopComponents(/*old_edges_only=*/false);
  std::vector<bool> held(components.count, false);
  std::vector<Index> first(components.count, kNone);
  for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
    if (!top.nodes[n].alive) continue;
    const int c = components.of_node[n];
    if (first[c] == kNone) first[c] = n;
    if (top.nodes[n].fixed > 0) held[c] = true;
    ForEachEdge(top, n, [&](Index, Index other) {
      if (other == kNone) held[c] = true;
    });
  }
  std::vector<std::pair<std::int64_t, Index>> by_age;
  for (const auto& [node, age] : anchors_) by_age.emplace_back(age, node);
  std::sort(by_age.begin(), by_age.end());
  anchors_.clear();
  const auto hold = [&](Index node, std::int64_t age) {
    hierarchy_.SetFixed(node, true);
    anchors_[node] = age;
  };
  for (const auto& [age, node] : by_age) {
    const int c = components.of_node[TopAncestor(node)];
    if (held[c]) {
      Disturb(0, node);
    } else {
      held[c] = true;
      hold(node, age);
    }
  }
  for (int c = 0; c < components.count; ++c) {
    if (held[c]) continue;
    Index node = first[c];
    for (int k = l; k > 0; --k) {
      node = hierarchy_.level(k).nodes[node].first_child;
      // Children are listed newest first.
      for (Index next; (next = hierarchy_.level(k - 1).nodes[node].next_sibling) != kNone;) {
        node = next;
      }
    }
    hold(node, next_anchor_++);
  }
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
