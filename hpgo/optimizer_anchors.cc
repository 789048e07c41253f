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

// kNone where no group is known yet.
template <typename G>
Index Optimizer<G>::Impl::TopAncestor(Index node) const {
  const Index kept = graph_.KeptNear(node);
  if (kept == kNone) return kNone;
  return hierarchy_.Ancestor(graph_.LevelNodeOf(kept), hierarchy_.num_levels() - 1);
}

template <typename G>
bool Optimizer<G>::Impl::HasPrior(Index node) const {
  bool has_prior = false;
  graph_.ForEachEdgeOf(node, [&](Index, Index other) { has_prior |= other == kNone; });
  return has_prior;
}

template <typename G>
typename Optimizer<G>::Impl::TopComponents Optimizer<G>::Impl::FindTopComponents() const {
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
      ForEachEdge(top, at, [&](Index, Index other) {
        if (other == kNone || components.of_node[other] >= 0) return;
        components.of_node[other] = components.count;
        queue.push_back(other);
      });
    }
    ++components.count;
  }
  return components;
}

// Where a new edge joins two components, one of which nothing but its first node holds, that one
// moves as a whole to fit the edge: from far off, no local solve would bring it there. Comes before
// the new edges are put in place, so that the top level still shows the components as they were.
template <typename G>
void Optimizer<G>::Impl::AlignJoinedComponents() {
  if (anchors_.size() + !fixed_.empty() + (num_priors_ > 0) < 2) return;
  const int l = hierarchy_.num_levels() - 1;
  const Level<G>& top = hierarchy_.level(l);
  const TopComponents components = FindTopComponents();
  std::vector<std::int64_t> holder = FindHolders(components);
  std::vector<int> merged(components.count);  // component -> what it has been joined to
  std::iota(merged.begin(), merged.end(), 0);
  std::map<Index, int> lone;  // nodes of no group yet: each a component
  const auto component_of = [&](Index node) {
    const Index group = TopAncestor(node);
    if (group != kNone) return components.of_node[group];
    const auto [it, is_new] = lone.emplace(node, static_cast<int>(merged.size()));
    if (is_new) {
      merged.push_back(it->second);
      holder.push_back(fixed_.count(node) > 0 || HasPrior(node) ? kCaller : kNothing);
    }
    return it->second;
  };
  for (const EdgeId id : new_edges_) {
    const Result<Index> edge = FindEdge(id);
    if (!edge.ok() || graph_.End(*edge, 0) == kNone) continue;
    const Index ends[2] = {graph_.End(*edge, 0), graph_.End(*edge, 1)};
    int side[2];
    for (int s = 0; s < 2; ++s) {
      const int component = component_of(ends[s]);
      side[s] = merged[component];
    }
    if (side[0] == side[1]) continue;
    const int weak = holder[side[0]] > holder[side[1]] ? 0 : 1;
    const int moving = side[weak], staying = side[1 - weak];
    if (holder[moving] != kCaller && holder[moving] != kNothing) {
      const G X_i = graph_.WorldPose(ends[0]), X_j = graph_.WorldPose(ends[1]);
      const G& Z = graph_.FactorOf(*edge).term->measurement;
      const G correction = weak == 1 ? X_i * Z * X_j.Inverse() : X_j * Z.Inverse() * X_i.Inverse();
      for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
        if (!top.nodes[n].alive || components.of_node[n] < 0) continue;
        if (merged[components.of_node[n]] != moving) continue;
        hierarchy_.SetWorldPose(l, n, correction * top.nodes[n].pose);
      }
      for (const auto& [node, component] : lone) {
        if (merged[component] != moving) continue;
        graph_.SetWorldPose(node, correction * graph_.WorldPose(node));
      }
    }
    std::replace(merged.begin(), merged.end(), moving, staying);
  }
}

// By component, what holds it: the caller (a fixed node, a prior), the age of an anchor, nothing.
template <typename G>
std::vector<std::int64_t> Optimizer<G>::Impl::FindHolders(const TopComponents& components) const {
  std::vector<std::int64_t> holder(components.count, kNothing);
  const auto hold = [&](Index node, std::int64_t age) {
    const Index group = TopAncestor(node);
    if (group == kNone) return;
    std::int64_t& h = holder[components.of_node[group]];
    h = std::min(h, age);
  };
  for (const auto& [node, age] : anchors_) hold(node, age);
  for (const Index node : fixed_) hold(node, kCaller);
  if (num_priors_ == 0) return holder;
  const Level<G>& top = hierarchy_.level(hierarchy_.num_levels() - 1);
  for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
    if (!top.nodes[n].alive) continue;
    ForEachEdge(top, n, [&](Index, Index other) {
      if (other == kNone) holder[components.of_node[n]] = kCaller;
    });
  }
  return holder;
}

// Gives every component that neither a fixed node nor a prior holds exactly one anchor: the oldest
// it has, else its first node.
template <typename G>
void Optimizer<G>::Impl::HoldComponents() {
  const int l = hierarchy_.num_levels() - 1;
  for (const auto& [node, age] : anchors_) {
    hierarchy_.SetFixed(graph_.LevelNodeOf(node), false);
  }
  const Level<G>& top = hierarchy_.level(l);
  const TopComponents components = FindTopComponents();
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
    graph_.SetHeld(node, true);
    hierarchy_.SetFixed(graph_.LevelNodeOf(node), true);
    anchors_[node] = age;
  };
  for (const auto& [age, node] : by_age) {
    const int c = components.of_node[TopAncestor(node)];
    if (held[c]) {
      graph_.SetHeld(node, false);
      Disturb(node);
    } else {
      held[c] = true;
      hold(node, age);
    }
  }
  for (const Index node : graph_.roots()) {
    const int c = components.of_node[TopAncestor(node)];
    if (held[c]) continue;
    held[c] = true;
    hold(node, next_anchor_++);
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
    hold(graph_.NodeOfLevel(node), next_anchor_++);
  }
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
