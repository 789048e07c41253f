#include "hpgo/update/gauge.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

// Holders of a component other than anchors, which are numbered by age: the smaller, the stronger.
constexpr std::int64_t kCaller = -1;
constexpr std::int64_t kNothing = std::numeric_limits<std::int64_t>::max();

// kNone where no group is known yet.
template <typename G>
Index TopAncestor(const CondensedGraph<G>& graph, Index node) {
  const Index kept = graph.KeptNear(node);
  if (kept == kNone) return kNone;
  const Hierarchy<G>& hierarchy = graph.hierarchy();
  return hierarchy.Ancestor(graph.LevelNodeOf(kept), hierarchy.num_levels() - 1);
}

template <typename G>
bool HasPrior(const CondensedGraph<G>& graph, Index node) {
  bool has_prior = false;
  graph.ForEachEdgeOf(node, [&](Index, Index other) { has_prior |= other == kNone; });
  return has_prior;
}

}  // namespace

template <typename G>
bool Gauge<G>::SetFixed(Index node, bool fixed, CondensedGraph<G>* graph) {
  if (fixed == IsFixed(node)) return false;
  anchors_.erase(node);
  graph->SetHeld(node, fixed);
  if (fixed) {
    fixed_.insert(node);
  } else {
    fixed_.erase(node);
  }
  is_due_ = true;
  return true;
}

template <typename G>
void Gauge<G>::Forget(Index node) {
  anchors_.erase(node);
  fixed_.erase(node);
  is_due_ = true;
}

template <typename G>
void Gauge<G>::NotePriors(int added) {
  num_priors_ += added;
  is_due_ = true;
}

template <typename G>
typename Gauge<G>::Components Gauge<G>::FindComponents(const Hierarchy<G>& hierarchy) {
  const Level<G>& top = hierarchy.level(hierarchy.num_levels() - 1);
  Components components;
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

template <typename G>
void Gauge<G>::AlignJoined(const std::vector<Index>& new_edges, CondensedGraph<G>* graph) {
  if (!is_due_ || NumHolders() < 2) return;
  Hierarchy<G>& hierarchy = graph->hierarchy();
  const int l = hierarchy.num_levels() - 1;
  const Level<G>& top = hierarchy.level(l);
  const Components components = FindComponents(hierarchy);
  std::vector<std::int64_t> holder = FindHolders(components, *graph);
  std::vector<int> merged(components.count);  // component -> what it has been joined to
  std::iota(merged.begin(), merged.end(), 0);
  std::map<Index, int> lone;  // nodes of no group yet: each a component
  const auto component_of = [&](Index node) {
    const Index group = TopAncestor(*graph, node);
    if (group != kNone) return components.of_node[group];
    const auto [it, is_new] = lone.emplace(node, static_cast<int>(merged.size()));
    if (is_new) {
      merged.push_back(it->second);
      holder.push_back(IsFixed(node) || HasPrior(*graph, node) ? kCaller : kNothing);
    }
    return it->second;
  };
  for (const Index edge : new_edges) {
    const Index ends[2] = {graph->End(edge, 0), graph->End(edge, 1)};
    if (ends[0] == kNone) continue;
    int side[2];
    for (int s = 0; s < 2; ++s) {
      const int component = component_of(ends[s]);
      side[s] = merged[component];
    }
    if (side[0] == side[1]) continue;
    const int weak = holder[side[0]] > holder[side[1]] ? 0 : 1;
    const int moving = side[weak], staying = side[1 - weak];
    if (holder[moving] != kCaller && holder[moving] != kNothing) {
      const G X_i = graph->WorldPose(ends[0]), X_j = graph->WorldPose(ends[1]);
      const G& Z = graph->FactorOf(edge).term->measurement;
      const G correction = weak == 1 ? X_i * Z * X_j.Inverse() : X_j * Z.Inverse() * X_i.Inverse();
      for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
        if (!top.nodes[n].alive || components.of_node[n] < 0) continue;
        if (merged[components.of_node[n]] != moving) continue;
        hierarchy.SetWorldPose(l, n, correction * top.nodes[n].pose);
      }
      for (const auto& [node, component] : lone) {
        if (merged[component] != moving) continue;
        graph->SetWorldPose(node, correction * graph->WorldPose(node));
      }
    }
    std::replace(merged.begin(), merged.end(), moving, staying);
  }
}

// By component, what holds it: the caller (a fixed node, a prior), the age of an anchor, nothing.
template <typename G>
std::vector<std::int64_t> Gauge<G>::FindHolders(const Components& components,
                                                const CondensedGraph<G>& graph) const {
  std::vector<std::int64_t> holder(components.count, kNothing);
  const auto hold = [&](Index node, std::int64_t age) {
    const Index group = TopAncestor(graph, node);
    if (group == kNone) return;
    std::int64_t& h = holder[components.of_node[group]];
    h = std::min(h, age);
  };
  for (const auto& [node, age] : anchors_) hold(node, age);
  for (const Index node : fixed_) hold(node, kCaller);
  if (num_priors_ == 0) return holder;
  const Level<G>& top = graph.hierarchy().level(graph.hierarchy().num_levels() - 1);
  for (Index n = 0; n < static_cast<Index>(top.nodes.size()); ++n) {
    if (!top.nodes[n].alive) continue;
    ForEachEdge(top, n, [&](Index, Index other) {
      if (other == kNone) holder[components.of_node[n]] = kCaller;
    });
  }
  return holder;
}

template <typename G>
std::vector<Index> Gauge<G>::Hold(CondensedGraph<G>* graph) {
  std::vector<Index> released;
  is_due_ |= graph->has_new_component();
  if (!std::exchange(is_due_, false)) return released;
  Hierarchy<G>& hierarchy = graph->hierarchy();
  const int l = hierarchy.num_levels() - 1;
  for (const auto& [node, age] : anchors_) {
    hierarchy.SetFixed(graph->LevelNodeOf(node), false);
  }
  const Level<G>& top = hierarchy.level(l);
  const Components components = FindComponents(hierarchy);
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
    graph->SetHeld(node, true);
    hierarchy.SetFixed(graph->LevelNodeOf(node), true);
    anchors_[node] = age;
  };
  for (const auto& [age, node] : by_age) {
    const int c = components.of_node[TopAncestor(*graph, node)];
    if (held[c]) {
      graph->SetHeld(node, false);
      released.push_back(node);
    } else {
      held[c] = true;
      hold(node, age);
    }
  }
  for (const Index node : graph->roots()) {
    const int c = components.of_node[TopAncestor(*graph, node)];
    if (held[c]) continue;
    held[c] = true;
    hold(node, next_age_++);
  }
  for (int c = 0; c < components.count; ++c) {
    if (held[c]) continue;
    Index node = first[c];
    for (int k = l; k > 0; --k) {
      node = hierarchy.level(k).nodes[node].first_child;
      // Children are listed newest first.
      for (Index next; (next = hierarchy.level(k - 1).nodes[node].next_sibling) != kNone;) {
        node = next;
      }
    }
    hold(graph->NodeOfLevel(node), next_age_++);
  }
  return released;
}

template class Gauge<SE2>;
template class Gauge<SE3>;
template class Gauge<YawPose>;

}  // namespace hpgo
