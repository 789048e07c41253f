// One level of the hierarchy: nodes and edges in stable storage, linked into adjacency lists.
#pragma once

#include <cstdint>
#include <vector>

#include "ceres_costs/factor_term.h"
#include "hpgo/hierarchy/chunked_vector.h"
#include "hpgo/hierarchy/pending_queue.h"

namespace hpgo {

using Index = std::int32_t;         // of a node or an edge within its level
inline constexpr Index kNone = -1;  // no such node or edge; as an edge's first end: the world frame

// A bound on a motion: of any point of a pose's subtree, and of its orientation.
struct MotionBound {
  float distance = 0;  // m
  float angle = 0;     // rad

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.distance, self.angle);
  }
};

template <typename G>
struct LevelNode {
  G pose;  // T_parent_node; T_world_node where there is no parent
  Index parent = kNone;
  Index first_child = kNone, num_children = 0;  // on the level below
  Index next_sibling = kNone, prev_sibling = kNone;
  Index first_edge = kNone, degree = 0;
  std::int32_t fixed = 0;  // level 0: is it constant; above: how many children hold a constant node
  bool alive = false;
  // Scratch of whoever walks the level: valid where stamp equals the walker's.
  std::uint32_t stamp = 0;
  Index scratch = 0;
  double weight = 0;  // k: the sum of the weights of its edges (paper, eq. 1)
  // While motions are tracked, bounds since they were last reported: of this node in its parent's
  // frame, and of its descendants in its own; and the reach of its descendants, or of what hangs on
  // a node of level 0, from its origin.
  MotionBound moved, below;
  float radius = 0;

  // All but the scratch.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.pose, self.parent, self.first_child, self.num_children, self.next_sibling,
            self.prev_sibling, self.first_edge, self.degree, self.fixed, self.alive, self.weight,
            self.moved, self.below, self.radius);
  }
};

// What became of a chain whose ends have moved.
enum class RefreshedChain {
  kHolds,  // its term does there
  kAnew,   // it has another term now
  kLags,   // it could not follow, and is to be cut
};

// Of a step that may be taken back.
enum class ChainTrial {
  kBegin,    // chains are to be remembered as they are before they are refreshed
  kPutBack,  // those are put back; another trial begins
  kEnd,      // what is there stays
};

// The links and the bookkeeping; the measurement is kept apart, in Level::terms, for the walks that
// do not need it.
struct LevelEdge {
  Index node[2] = {kNone, kNone};  // node[0] is kNone for a prior: the world frame
  Index next[2] = {kNone, kNone}, prev[2] = {kNone, kNone};  // adjacency lists of the two ends
  Index parent = kNone;                                      // on the level above
  Index first_child = kNone, num_children = 0;               // on the level below
  Index next_sibling = kNone, prev_sibling = kNone;
  Index queue_next = kNone, queue_prev = kNone;  // in Level::pending
  float pending = 0;  // an unexamined change on this level, in sqrt(chi2)
  float changed = 0;  // the change of the children since this edge was last merged, in sqrt(chi2)
  float chi2 = 0;     // above level 0: of the edges of level 0 below, when it was last merged
  double weight = 0;  // W of the modularity (paper, eq. 2); above level 0 the sum of the children's
  bool alive = false;
  bool merged = false;           // level 0: is no longer new; above: the term holds a merge
  bool queued = false;           // is in Level::pending
  bool dirty = false;            // is in Level::dirty
  bool centred = false;          // its next merge measures the current estimate (kCondensed)
  bool condensed = false;        // level 0: stands for a chain
  bool lags = false;             // one that does not follow its ends; kept by who keeps the chains
  Index extra = kNone;           // level 0: more data (loss, offset, custom cost), if it has any
  std::uint32_t generation = 0;  // counts the edges that have had this index

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.node, self.next, self.prev, self.parent, self.first_child, self.num_children,
            self.next_sibling, self.prev_sibling, self.queue_next, self.queue_prev, self.pending,
            self.changed, self.chi2, self.weight, self.alive, self.merged, self.queued, self.dirty,
            self.centred, self.condensed, self.lags, self.extra, self.generation);
  }
};

template <typename G>
struct Level {
  ChunkedVector<LevelNode<G>> nodes;
  ChunkedVector<LevelEdge> edges;
  ChunkedVector<ceres_costs::RelativePoseTerm<G>> terms;  // by edge
  std::vector<Index> free_nodes, free_edges;              // indices to use again
  Index num_nodes = 0, num_edges = 0;                     // alive
  double total_weight = 0;                                // m (paper, eq. 1)
  PendingQueue pending;
  std::vector<Index> dirty;  // edges to merge; may hold dead ones

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.nodes, self.edges, self.terms, self.free_nodes, self.free_edges, self.num_nodes,
            self.num_edges, self.total_weight, self.pending, self.dirty);
  }
};

// The end of an edge away from `node`; kNone is the world frame.
inline Index OtherEnd(const LevelEdge& edge, Index node) {
  return edge.node[0] == node ? edge.node[1] : edge.node[0];
}

// Calls visit(edge index, other end) for the edges of a node, newest first. The visitor may not
// change the node's adjacency.
template <typename G, typename Visitor>
void ForEachEdge(const Level<G>& level, Index node, Visitor&& visit) {
  for (Index e = level.nodes[node].first_edge; e != kNone;) {
    const LevelEdge& edge = level.edges[e];
    const int side = edge.node[1] == node;
    const Index next = edge.next[side];
    visit(e, edge.node[1 - side]);
    e = next;
  }
}

}  // namespace hpgo
