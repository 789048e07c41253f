// The condensed graph: poses. Those of interiors follow from the kept nodes.

#include <utility>

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

// T of a chain's first and last node: the estimate, or what its measurements say.
template <typename G>
G CondensedGraph<G>::TargetOf(Chain& chain) {
  if (IsEnd(chain, 0) && IsEnd(chain, 1)) {
    return hierarchy_.RelativePose(0, nodes_[chain.node[0]].level_node,
                                   nodes_[chain.node[1]].level_node);
  }
  if (!chain.composed) ComposeFreeEnd(&chain);
  return IsEnd(chain, 0) ? chain.T_kept_free : chain.T_kept_free.Inverse();
}

// T_world_first of a chain with T of its ends.
template <typename G>
G CondensedGraph<G>::OriginOf(const Chain& chain, const G& T) {
  if (IsEnd(chain, 0)) return hierarchy_.WorldPose(0, nodes_[chain.node[0]].level_node);
  return hierarchy_.WorldPose(0, nodes_[chain.node[1]].level_node) * T.Inverse();
}

// Where a chain has a free end: the measurements composed, which is the optimum. O(1) where the
// chain has grown by an edge, else O(length).
template <typename G>
void CondensedGraph<G>::ComposeFreeEnd(Chain* chain) {
  const G T = spans_.Relax(chain->root);
  chain->length = spans_.Model(chain->root).length;
  chain->T_kept_free = IsEnd(*chain, 0) ? T : T.Inverse();
  chain->composed = true;
}

template <typename G>
G CondensedGraph<G>::WorldPose(Index n) {
  const Node& node = nodes_[n];
  if (node.level_node != kNone) return hierarchy_.WorldPose(0, node.level_node);
  if (node.loose) return loose_.at(n);
  return InteriorPose(n);
}

template <typename G>
G CondensedGraph<G>::InteriorPose(Index n) {
  Chain& chain = chains_[ChainOfNode(n)];
  const G T = TargetOf(chain);
  const G X = OriginOf(chain, T);
  if (n == chain.node[0]) return X;
  if (n == chain.node[1]) return X * T;
  const SplitPose<G> pose = spans_.PoseOf(EdgeInto(n), T, InsideOf(chain));
  return X * pose.first * pose.second;
}

template <typename G>
G CondensedGraph<G>::RelativePose(Index e) {
  const Edge& edge = edges_[e];
  if (edge.node[0] == kNone) return WorldPose(edge.node[1]);
  if (edge.place == Place::kLevel) {
    return hierarchy_.RelativePose(0, nodes_[edge.node[0]].level_node,
                                   nodes_[edge.node[1]].level_node);
  }
  if (edge.place == Place::kChain) {
    Chain& chain = chains_[ChainOf(e)];
    const G Y = spans_.PoseOf(edge.at, TargetOf(chain), InsideOf(chain)).second;
    return spans_.edge(edge.at).reversed ? Y.Inverse() : Y;
  }
  return WorldPose(edge.node[0]).Between(WorldPose(edge.node[1]));
}

// visit(node, T_world_node) for the nodes inside a chain and at its free end.
template <typename G>
template <typename Visitor>
void CondensedGraph<G>::ForEachInterior(Chain& chain, Visitor&& visit) {
  const G T = TargetOf(chain);
  G X = OriginOf(chain, T);
  if (!IsEnd(chain, 0)) visit(chain.node[0], X);
  spans_.ForEachEdge(chain.root, T, InsideOf(chain), [&](Index at, const G& Y) {
    const Index n = EnteredBy(at);
    X = (X * Y).Normalized();
    if (!IsKept(n)) visit(n, X);
  });
}

template <typename G>
void CondensedGraph<G>::ForEachPose(const std::function<void(Index, const G&)>& visit) {
  for (Index n = 0; n < static_cast<Index>(nodes_.size()); ++n) {
    if (nodes_[n].alive && (nodes_[n].loose || IsKept(n))) visit(n, WorldPose(n));
  }
  for (Chain& chain : chains_) {
    if (chain.alive) ForEachInterior(chain, visit);
  }
}

template <typename G>
void CondensedGraph<G>::ForEachRelativePose(const std::function<void(Index, const G&)>& visit) {
  for (Index e = 0; e < static_cast<Index>(edges_.size()); ++e) {
    if (edges_[e].alive && edges_[e].place != Place::kChain) visit(e, RelativePose(e));
  }
  for (Chain& chain : chains_) {
    if (!chain.alive) continue;
    spans_.ForEachEdge(chain.root, TargetOf(chain), InsideOf(chain), [&](Index at, const G& Y) {
      const ChainEdge<G>& edge = spans_.edge(at);
      visit(edge.edge, edge.reversed ? Y.Inverse() : Y);
    });
  }
}

// The nodes of a chain swing with its ends: their bounds on motions hold for it. `moved`: it has
// itself.
template <typename G>
void CondensedGraph<G>::NoteReach(const Chain& chain, bool moved) {
  if (!tracking_) return;
  for (int side = 0; side < 2; ++side) {
    if (IsEnd(chain, side)) {
      hierarchy_.HangBelow(nodes_[chain.node[side]].level_node, chain.length, moved);
    }
  }
}

template <typename G>
void CondensedGraph<G>::ForEachMoved(double distance, double angle,
                                     const std::function<void(Index, const G&)>& visit) {
  if (!tracking_) {
    tracking_ = true;
    while (reported_.size() < nodes_.size()) reported_.push_back(G());
    for (Chain& chain : chains_) {
      if (chain.alive) NoteReach(chain, true);
    }
  }
  ++moved_stamp_;
  const auto report = [&](Index n, const G& pose) {
    Node& node = nodes_[n];
    if (std::exchange(node.seen, moved_stamp_) == moved_stamp_) return;
    if (node.reported) {
      const typename G::Tangent d = reported_[n].LocalCoordinates(pose);
      if (!(d.template head<G::kDim>().norm() > distance) &&
          !(d.template tail<G::kRotationDof>().norm() > angle)) {
        return;
      }
    }
    node.reported = true;
    reported_[n] = pose;
    visit(n, pose);
  };
  const auto look = [&](Index level_node, const G& pose) {
    const Index n = node_of_level_[level_node];
    report(n, pose);
    ForEachEdgeOf(n, [&](Index e, Index) {
      if (edges_[e].place != Place::kChain) return;
      Chain& chain = chains_[ChainOf(e)];
      if (std::exchange(chain.stamp, moved_stamp_) == moved_stamp_) return;
      ForEachInterior(chain, report);
    });
  };
  for (const Index n : std::exchange(unreported_, {})) {
    if (nodes_[n].alive && !nodes_[n].reported) report(n, WorldPose(n));
  }
  hierarchy_.LookAtMoved(distance, angle, look, [](Index, const G&) {});
  for (const auto& [n, pose] : loose_) report(n, pose);
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
