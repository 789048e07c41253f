// Which poses have moved, without looking at all of them: bounds on motions, kept like the pending
// sums of a lazy segment tree. A node's true motion never exceeds the sum of the bounds above it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "ceres_costs/so3.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// How far a pose has moved, seen from where it was.
template <typename G>
MotionBound MotionOf(const G& before, const G& after) {
  const typename G::Tangent d = before.LocalCoordinates(after);
  MotionBound motion;
  motion.distance = static_cast<float>(d.template head<G::kDim>().norm());
  motion.angle = static_cast<float>(d.template tail<G::kRotationDof>().norm());
  return motion;
}

void Add(const MotionBound& more, MotionBound* sum) {
  sum->distance += more.distance;
  sum->angle += more.angle;
}

bool Exceeds(const MotionBound& a, const MotionBound& b, const MotionBound& limit) {
  return a.distance + b.distance > limit.distance || a.angle + b.angle > limit.angle;
}

}  // namespace

template <typename G>
void Hierarchy<G>::NoteMove(int l, Index n, const G& before) {
  LevelNode<G>& node = levels_[l]->nodes[n];
  MotionBound motion = MotionOf(before, node.pose);
  motion.distance += motion.angle * node.radius;  // a point of the subtree swings around the origin
  Add(motion, &node.moved);
  RaiseBounds(l, n);
  RaiseRadius(l, n);
}

// Carries a node's bounds up to its ancestors.
template <typename G>
void Hierarchy<G>::RaiseBounds(int l, Index n) {
  while (true) {
    const LevelNode<G>& node = levels_[l]->nodes[n];
    if (node.parent == kNone) return;
    MotionBound& below = levels_[l + 1]->nodes[node.parent].below;
    const float distance = node.moved.distance + node.below.distance;
    const float angle = node.moved.angle + node.below.angle;
    if (distance <= below.distance && angle <= below.angle) return;
    below.distance = std::max(below.distance, distance);
    below.angle = std::max(below.angle, angle);
    n = node.parent;
    ++l;
  }
}

template <typename G>
void Hierarchy<G>::RaiseRadius(int l, Index n) {
  while (true) {
    const LevelNode<G>& node = levels_[l]->nodes[n];
    if (node.parent == kNone) return;
    float& radius = levels_[l + 1]->nodes[node.parent].radius;
    const float reach = static_cast<float>(node.pose.translation().norm()) + node.radius;
    if (reach <= radius) return;
    // A little more, so that a group that creeps outwards does not climb here at every step.
    radius = 1.1f * reach;
    n = node.parent;
    ++l;
  }
}

template <typename G>
void Hierarchy<G>::StartTracking() {
  tracking_ = true;
  while (reported_.size() < levels_[0]->nodes.size()) reported_.push_back(G());
  for (int l = 0; l < num_levels(); ++l) {
    Level<G>& level = *levels_[l];
    for (Index n = 0; n < static_cast<Index>(level.nodes.size()); ++n) {
      if (!level.nodes[n].alive) continue;
      if (l == 0) level.nodes[n].moved.distance = std::numeric_limits<float>::infinity();
      RaiseBounds(l, n);
      RaiseRadius(l, n);
    }
  }
}

template <typename G>
void Hierarchy<G>::VisitMoved(int l, Index n, const MotionBound& limit,
                              const std::function<void(Index, const G&)>& look,
                              const std::function<void(Index, const G&)>& visit) {
  LevelNode<G>& node = levels_[l]->nodes[n];
  if (!Exceeds(node.moved, node.below, limit)) return;
  if (l == 0) {
    const G pose = WorldPose(0, n);
    if (look) look(n, pose);
    node.below = MotionBound();
    MotionBound motion = MotionOf(reported_[n], pose);
    if (std::isinf(node.moved.distance) || Exceeds(motion, MotionBound(), limit)) {
      reported_[n] = pose;
      motion = MotionBound();
      visit(n, pose);
    }
    node.moved = motion;
    return;
  }
  Level<G>& below = *levels_[l - 1];
  const MotionBound own = node.moved;
  node.moved = node.below = MotionBound();
  for (Index c = node.first_child; c != kNone; c = below.nodes[c].next_sibling) {
    Add(own, &below.nodes[c].moved);
    VisitMoved(l - 1, c, limit, look, visit);
    const LevelNode<G>& child = below.nodes[c];
    node.below.distance =
        std::max(node.below.distance, child.moved.distance + child.below.distance);
    node.below.angle = std::max(node.below.angle, child.moved.angle + child.below.angle);
  }
}

template <typename G>
void Hierarchy<G>::HangBelow(Index n, float reach, bool moved) {
  if (!tracking_) return;
  LevelNode<G>& node = levels_[0]->nodes[n];
  node.radius = std::max(node.radius, reach);
  if (moved) node.below.distance = std::numeric_limits<float>::infinity();
  RaiseBounds(0, n);
  RaiseRadius(0, n);
}

template <typename G>
void Hierarchy<G>::LookAtMoved(double distance, double angle,
                               const std::function<void(Index, const G&)>& look,
                               const std::function<void(Index, const G&)>& visit) {
  if (!tracking_) StartTracking();
  MotionBound limit;
  limit.distance = static_cast<float>(distance);
  limit.angle = static_cast<float>(angle);
  // Nodes that no group has yet hang from nothing. They may wait more than once.
  const std::uint32_t visited = NewStamp();
  for (const LevelItem& item : unassigned_) {
    LevelNode<G>& node = levels_[item.l]->nodes[item.index];
    if (!node.alive || node.parent != kNone || node.stamp == visited) continue;
    node.stamp = visited;
    VisitMoved(item.l, item.index, limit, look, visit);
  }
  const int top = num_levels() - 1;
  for (Index n = 0; n < static_cast<Index>(levels_[top]->nodes.size()); ++n) {
    const LevelNode<G>& node = levels_[top]->nodes[n];
    if (node.alive && node.stamp != visited) VisitMoved(top, n, limit, look, visit);
  }
}

template class Hierarchy<SE2>;
template class Hierarchy<SE3>;
template class Hierarchy<YawPose>;

}  // namespace hpgo
