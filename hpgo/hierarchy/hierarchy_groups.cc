// The groups of the hierarchy: who belongs to whom, their repair, and the levels.

#include <algorithm>

#include "hpgo/hierarchy/grouping.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/hierarchy/siblings.h"

namespace hpgo {

template <typename G>
void Hierarchy<G>::Attach(int l, Index n, Index group) {
  LevelNode<G>& node = levels_[l]->nodes[n];
  LevelNode<G>& parent = levels_[l + 1]->nodes[group];
  node.pose = WorldPose(l + 1, group).Between(node.pose).Normalized();
  node.parent = group;
  LinkSibling(n, &parent.first_child, &levels_[l]->nodes);
  ++parent.num_children;
  if (node.fixed > 0) AddFixed(l + 1, group, 1);
  if (tracking_) {
    RaiseBounds(l, n);
    RaiseRadius(l, n);
  }
  ForEachEdge(*levels_[l], n, [&](Index e, Index) { Lift(l, e); });
}

template <typename G>
void Hierarchy<G>::Detach(int l, Index n) {
  LevelNode<G>& node = levels_[l]->nodes[n];
  const Index group = node.parent;
  if (group == kNone) return;
  const G pose = WorldPose(l, n);
  if (tracking_) {  // what its ancestors have moved, it has moved
    for (Index k = l + 1, g = group; g != kNone; g = levels_[k++]->nodes[g].parent) {
      node.moved.distance += levels_[k]->nodes[g].moved.distance;
      node.moved.angle += levels_[k]->nodes[g].moved.angle;
    }
  }
  ForEachEdge(*levels_[l], n, [&](Index e, Index) { Unlift(l, e); });
  LevelNode<G>& parent = levels_[l + 1]->nodes[group];
  UnlinkSibling(n, &parent.first_child, &levels_[l]->nodes);
  node.parent = kNone;
  node.pose = pose.Normalized();
  --parent.num_children;
  if (node.fixed > 0) AddFixed(l + 1, group, -1);
  if (parent.num_children == 0) {
    DetachAndForget(l + 1, group);
  } else {
    suspects_.push_back({l + 1, group});
  }
}

template <typename G>
void Hierarchy<G>::DetachAndForget(int l, Index node) {
  Detach(l, node);
  FreeNode(l, node);
}

template <typename G>
void Hierarchy<G>::AssignGroup(int l, Index n) {
  if (l + 1 >= num_levels()) return;
  const Level<G>& level = *levels_[l];
  const LevelNode<G>& node = level.nodes[n];
  if (node.parent != kNone && levels_[l + 1]->nodes[node.parent].num_children > 1) return;
  std::vector<GroupCandidate> candidates;
  const std::uint32_t met = NewStamp();
  ForEachEdge(level, n, [&](Index e, Index other) {
    if (other == kNone) return;
    const Index group = level.nodes[other].parent;
    if (group == kNone || group == node.parent) return;
    LevelNode<G>& record = levels_[l + 1]->nodes[group];
    if (record.stamp != met) {
      record.stamp = met;
      record.scratch = static_cast<Index>(candidates.size());
      GroupCandidate& candidate = candidates.emplace_back();
      candidate.group = group;
      for (Index c = record.first_child; c != kNone; c = level.nodes[c].next_sibling) {
        ++candidate.size;
        candidate.group_weight += level.nodes[c].weight;
      }
    }
    candidates[record.scratch].weight_to_group += level.edges[e].weight;
  });
  const int best = BestGroup(candidates, node.weight, level.total_weight, options_.max_group_size);
  if (best >= 0) {
    Detach(l, n);
    Attach(l, n, candidates[best].group);
  } else if (node.parent == kNone) {
    const Index group = NewNode(l + 1, node.pose);
    Attach(l, n, group);
    AssignGroup(l + 1, group);
  }
}

template <typename G>
void Hierarchy<G>::RetryIfAlone(int l, Index n) {
  // One that has found no group among so many neighbours is not worth going through them again.
  constexpr Index kMaxDegree = 100;
  if (n == kNone || l + 1 >= num_levels() || levels_[l]->nodes[n].degree > kMaxDegree) return;
  const Index group = levels_[l]->nodes[n].parent;
  if (group != kNone && levels_[l + 1]->nodes[group].num_children == 1) {
    unassigned_.push_back({l, n});
  }
}

template <typename G>
bool Hierarchy<G>::SplitGroup(int l, Index group) {
  if (l >= num_levels() || !levels_[l]->nodes[group].alive) return false;
  const Level<G>& below = *levels_[l - 1];
  std::vector<Index> members;
  for (Index c = levels_[l]->nodes[group].first_child; c != kNone;
       c = below.nodes[c].next_sibling) {
    members.push_back(c);
  }
  std::size_t reached = 1;  // members[0, reached) are connected within the group
  for (std::size_t k = 0; k < reached; ++k) {
    ForEachEdge(below, members[k], [&](Index, Index other) {
      const auto it = std::find(members.begin() + reached, members.end(), other);
      if (it != members.end()) std::swap(*it, members[reached++]);
    });
  }
  for (std::size_t k = reached; k < members.size(); ++k) Detach(l - 1, members[k]);
  for (std::size_t k = reached; k < members.size(); ++k) AssignGroup(l - 1, members[k]);
  return reached < members.size();
}

template <typename G>
void Hierarchy<G>::RepairGroups() {
  while (!suspects_.empty()) {
    // Lowest level first: a repair may take groups apart further up.
    const auto lowest =
        std::min_element(suspects_.begin(), suspects_.end(),
                         [](const LevelItem& a, const LevelItem& b) { return a.l < b.l; });
    const LevelItem item = *lowest;
    suspects_.erase(lowest);
    SplitGroup(item.l, item.index);
  }
  DropSmallTop();
}

template <typename G>
void Hierarchy<G>::AddLevel() {
  levels_.push_back(std::make_unique<Level<G>>());
  const int l = num_levels() - 2;
  for (int pass = 0; pass < 2; ++pass) {  // the second for those that the first left alone
    for (Index n = 0; n < static_cast<Index>(levels_[l]->nodes.size()); ++n) {
      if (levels_[l]->nodes[n].alive) AssignGroup(l, n);
    }
  }
  if (options_.coarse_edges == CoarseEdges::kCondensed) CentreTop();
}

// The estimate is what the top so far has settled on. Composed from measurements, the edges of a
// new one would have another optimum, and the map would jump to it in rigid pieces. Not where edges
// are new or changed: the estimate does not hold them yet.
template <typename G>
void Hierarchy<G>::CentreTop() {
  const int l = num_levels() - 1;
  Level<G>& level = *levels_[l];
  const Level<G>& below = *levels_[l - 1];
  const auto is_fresh = [&](Index e) { return below.edges[e].dirty || !below.edges[e].merged; };
  const auto has_fresh = [&](Index group) {  // between its members
    bool fresh = false;
    for (Index c = level.nodes[group].first_child; c != kNone; c = below.nodes[c].next_sibling) {
      ForEachEdge(below, c, [&](Index e, Index other) {
        if (other != kNone && below.nodes[other].parent == group) fresh |= is_fresh(e);
      });
    }
    return fresh;
  };
  for (const Index e : level.dirty) {
    LevelEdge& record = level.edges[e];
    if (!record.alive || record.node[0] == kNone) continue;
    bool fresh = has_fresh(record.node[0]) || has_fresh(record.node[1]);
    for (Index c = record.first_child; c != kNone; c = below.edges[c].next_sibling) {
      fresh |= is_fresh(c);
    }
    record.centred = !fresh;
  }
}

template <typename G>
void Hierarchy<G>::DropTop() {
  const int l = num_levels() - 2;
  Level<G>& level = *levels_[l];
  for (Index n = 0; n < static_cast<Index>(level.nodes.size()); ++n) {
    LevelNode<G>& node = level.nodes[n];
    if (!node.alive || node.parent == kNone) continue;
    if (tracking_) {
      const MotionBound& up = levels_[l + 1]->nodes[node.parent].moved;
      node.moved.distance += up.distance;
      node.moved.angle += up.angle;
    }
    node.pose = WorldPose(l, n).Normalized();
    node.parent = node.next_sibling = node.prev_sibling = kNone;
  }
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    LevelEdge& edge = level.edges[e];
    edge.parent = edge.next_sibling = edge.prev_sibling = kNone;
  }
  levels_.pop_back();
  const auto of_top = [this](const LevelItem& item) { return item.l + 1 >= num_levels(); };
  unassigned_.erase(std::remove_if(unassigned_.begin(), unassigned_.end(), of_top),
                    unassigned_.end());
}

template <typename G>
bool Hierarchy<G>::IsTooLarge(int l, double share) const {
  return levels_[l]->num_nodes > share * options_.max_top_nodes ||
         levels_[l]->num_edges > share * options_.max_top_edges;
}

template <typename G>
void Hierarchy<G>::DropSmallTop() {
  // Half of T, so that a graph that grows and shrinks does not build and drop levels in turns.
  while (num_levels() > 1 && !IsTooLarge(num_levels() - 2, 0.5)) {
    DropTop();
    next_new_level_ = 0;
  }
}

template class Hierarchy<ceres_costs::SE2>;
template class Hierarchy<ceres_costs::SE3>;
template class Hierarchy<ceres_costs::YawPose>;

}  // namespace hpgo
