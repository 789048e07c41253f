#include "hpgo/solve/window.h"

#include <algorithm>

namespace hpgo {

template <typename G>
bool Window<G>::Build(int l, const std::vector<Index>& seeds, const WindowLimits& limits,
                      Hierarchy<G>* hierarchy, Beyond beyond) {
  hierarchy_ = hierarchy;
  level_ = l;
  refused_ = hierarchy->NewStamp();
  stamp_ = hierarchy->NewStamp();
  nodes_.clear();
  Collect(seeds, limits);
  AddFactors(beyond, true);
  return subproblem_.num_free > 0;
}

template <typename G>
bool Window<G>::BuildWhole(int l, Hierarchy<G>* hierarchy, bool refresh_chains) {
  hierarchy_ = hierarchy;
  level_ = l;
  stamp_ = hierarchy->NewStamp();
  nodes_.clear();
  Level<G>& level = hierarchy->mutable_level(l);
  for (Index n = 0; n < static_cast<Index>(level.nodes.size()); ++n) {
    LevelNode<G>& node = level.nodes[n];
    if (!node.alive || node.fixed > 0) continue;
    node.stamp = stamp_;
    node.scratch = static_cast<Index>(nodes_.size());
    nodes_.push_back(n);
  }
  AddFactors(Beyond::kHeld, refresh_chains);
  return subproblem_.num_free > 0;
}

// Makes a node free unless it is constant or its edges do not fit. One that was refused is not
// asked again: where all see all, that would take a time that grows with the cube of their number.
template <typename G>
bool Window<G>::TryAdd(Index n, int max_edges) {
  Level<G>& level = hierarchy_->mutable_level(level_);
  LevelNode<G>& node = level.nodes[n];
  if (!node.alive || node.stamp == stamp_ || node.stamp == refused_ || node.fixed > 0) return false;
  int fresh = 0;  // edges that no free node has brought in yet
  ForEachEdge(level, n, [&](Index, Index other) {
    fresh += other == kNone || level.nodes[other].stamp != stamp_;
  });
  if (num_edges_ + fresh > max_edges && !nodes_.empty()) {
    node.stamp = refused_;
    return false;
  }
  num_edges_ += fresh;
  node.stamp = stamp_;
  node.scratch = static_cast<Index>(nodes_.size());
  nodes_.push_back(n);
  return true;
}

template <typename G>
void Window<G>::Collect(const std::vector<Index>& seeds, const WindowLimits& limits) {
  num_edges_ = 0;
  for (const Index seed : seeds) {
    if (static_cast<int>(nodes_.size()) >= limits.max_nodes) return;
    TryAdd(seed, limits.max_edges);
  }
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    const Level<G>& level = hierarchy_->level(level_);
    for (Index e = level.nodes[nodes_[k]].first_edge; e != kNone;) {
      if (static_cast<int>(nodes_.size()) >= limits.max_nodes) return;
      const LevelEdge& edge = level.edges[e];
      const int side = edge.node[1] == nodes_[k];
      if (edge.node[1 - side] != kNone) TryAdd(edge.node[1 - side], limits.max_edges);
      e = edge.next[side];
    }
  }
}

template <typename G>
void Window<G>::AddFactors(Beyond beyond, bool refresh_chains) {
  Level<G>& level = hierarchy_->mutable_level(level_);
  edges_.clear();
  frames_.clear();
  subproblem_.factors.clear();
  const std::size_t num_free = nodes_.size();
  subproblem_.num_free = static_cast<int>(num_free);
  bool held = false;
  for (std::size_t k = 0; k < num_free; ++k) {
    ForEachEdge(level, nodes_[k], [&](Index e, Index other) {
      Factor<G> factor;
      if (other == kNone) {
        held = true;
      } else {
        LevelNode<G>& end = level.nodes[other];
        if (end.stamp != stamp_) {
          if (beyond == Beyond::kLeftOut && end.fixed == 0) return;
          end.stamp = stamp_;
          end.scratch = static_cast<Index>(nodes_.size());
          nodes_.push_back(other);
        } else if (end.scratch < static_cast<Index>(k)) {
          return;  // came with the other end
        }
        held |= end.scratch >= static_cast<Index>(num_free);
        factor.i = level.nodes[level.edges[e].node[0]].scratch;
      }
      if (level_ > 0 && !level.edges[e].merged) hierarchy_->Merge(level_, e);
      factor.j = level.nodes[level.edges[e].node[1]].scratch;
      static_cast<ceres_costs::FactorTerm<G>&>(factor) = hierarchy_->FactorOf(level_, e);
      subproblem_.factors.push_back(factor);
      edges_.push_back(e);
    });
  }
  if (!held && num_free > 0) HoldGauge();
  subproblem_.poses.clear();
  for (const Index n : nodes_) {
    const LevelNode<G>& node = level.nodes[n];
    subproblem_.poses.push_back(
        node.parent == kNone ? node.pose : FrameOf(level_ + 1, node.parent) * node.pose);
  }
  before_ = subproblem_.poses;
  if (refresh_chains) RefreshChains();
}

// Chains that have been bent since they were linearized; their factors point to the new terms.
template <typename G>
bool Window<G>::RefreshChains() {
  bool any = false;
  for (std::size_t k = 0; k < edges_.size() && level_ == 0; ++k) {
    if (hierarchy_->level(0).edges[edges_[k]].condensed) {
      any |= hierarchy_->Refresh(edges_[k], RelativePose(k));
    }
  }
  return any;
}

template <typename G>
bool Window<G>::Lags() const {
  const auto& edges = hierarchy_->level(0).edges;
  return level_ == 0 &&
         std::any_of(edges_.begin(), edges_.end(), [&](Index e) { return edges[e].lags; });
}

template <typename G>
double Window<G>::Cost() const {
  double cost = 0;
  for (std::size_t k = 0; k < edges_.size(); ++k) {
    cost += hierarchy_->CostAt(edges_[k], RelativePose(k));
  }
  return cost;
}

// Nothing holds the window: its first node becomes constant, the last of the list.
template <typename G>
void Window<G>::HoldGauge() {
  Level<G>& level = hierarchy_->mutable_level(level_);
  const Index first = 0, last = static_cast<Index>(nodes_.size()) - 1;
  std::swap(nodes_[first], nodes_[last]);
  std::swap(level.nodes[nodes_[first]].scratch, level.nodes[nodes_[last]].scratch);
  for (Factor<G>& factor : subproblem_.factors) {
    for (int* end : {&factor.i, &factor.j}) {
      if (*end == first) {
        *end = last;
      } else if (*end == last) {
        *end = first;
      }
    }
  }
  --subproblem_.num_free;
}

// T_world_group, computed once a window.
template <typename G>
const G& Window<G>::FrameOf(int l, Index n) {
  LevelNode<G>& node = hierarchy_->mutable_level(l).nodes[n];
  if (node.stamp != stamp_) {
    const G frame = node.parent == kNone ? node.pose : FrameOf(l + 1, node.parent) * node.pose;
    node.stamp = stamp_;
    node.scratch = static_cast<Index>(frames_.size());
    frames_.push_back(frame);
  }
  return frames_[node.scratch];
}

template <typename G>
bool Window<G>::IsFree(Index n) const {
  const LevelNode<G>& node = hierarchy_->level(level_).nodes[n];
  return node.stamp == stamp_ && node.scratch < subproblem_.num_free;
}

template <typename G>
bool Window<G>::IsInterior(std::size_t k) const {
  const Factor<G>& factor = subproblem_.factors[k];
  return factor.i < subproblem_.num_free && factor.j < subproblem_.num_free;
}

template <typename G>
std::optional<std::pair<G, G>> Window<G>::PosesBetween(Index i, Index j) const {
  Index ends[2] = {i, j};
  G within[2];  // their poses in the nodes of this level that they belong to
  for (int side = 0; side < 2; ++side) {
    for (int l = 0; l < level_ && ends[side] != kNone; ++l) {
      const LevelNode<G>& node = hierarchy_->level(l).nodes[ends[side]];
      within[side] = node.pose * within[side];
      ends[side] = node.parent;
    }
    if (ends[side] == kNone) return std::nullopt;
  }
  if (ends[0] == ends[1] || (!IsFree(ends[0]) && !IsFree(ends[1]))) return std::nullopt;
  const auto& nodes = hierarchy_->level(level_).nodes;
  const auto between = [&](const std::vector<G>& poses) {
    return (poses[nodes[ends[0]].scratch] * within[0])
        .Between(poses[nodes[ends[1]].scratch] * within[1]);
  };
  return std::make_pair(between(before_), between(subproblem_.poses));
}

template <typename G>
void Window<G>::Restart() {
  before_ = subproblem_.poses;
}

template <typename G>
void Window<G>::ShortenStep(double share) {
  for (int k = 0; k < subproblem_.num_free; ++k) {
    G& pose = subproblem_.poses[k];
    pose = before_[k].Plus(share * pose.Minus(before_[k]));
  }
}

template <typename G>
void Window<G>::TakeBack() {
  subproblem_.poses = before_;
}

template <typename G>
void Window<G>::Commit(Hierarchy<G>* hierarchy) const {
  for (int k = 0; k < subproblem_.num_free; ++k) {
    const Index parent = hierarchy->level(level_).nodes[nodes_[k]].parent;
    const G& pose = subproblem_.poses[k];
    if (parent == kNone) {
      hierarchy->SetLocalPose(level_, nodes_[k], pose);
    } else {
      const Index frame = hierarchy->level(level_ + 1).nodes[parent].scratch;
      hierarchy->SetLocalPose(level_, nodes_[k], frames_[frame].Between(pose));
    }
  }
}

template class Window<ceres_costs::SE2>;
template class Window<ceres_costs::SE3>;
template class Window<ceres_costs::YawPose>;

}  // namespace hpgo
