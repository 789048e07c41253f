// What the condensed graph keeps of its nodes, edges and chains, and what it hands out of them. The
// names that end in _ are fields of CondensedGraph.
#pragma once

#include <cstdint>

#include "hpgo/chains/span_tree.h"

namespace hpgo {

// Where the data of an edge is.
enum class EdgePlace : std::uint8_t {
  kNew,    // in new_data_
  kLevel,  // an edge of level 0
  kChain,  // a part of a chain
};

struct NodeRecord {
  Index first_edge = kNone, degree = 0;  // priors among them
  Index level_node = kNone;              // kNone: not kept
  Index binding = 0;                     // priors and edges that bind
  std::uint32_t born = 0;                // orders the nodes by age
  std::uint32_t seen = 0;                // the last ForEachMoved that looked at it
  bool alive = false;
  bool held = false;
  bool root = false;      // kept for want of another kept node in its component
  bool touched = false;   // is in touched_
  bool loose = false;     // its pose is in loose_
  bool reported = false;  // its pose is in reported_

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.first_edge, self.degree, self.level_node, self.binding, self.born, self.seen,
            self.alive, self.held, self.root, self.touched, self.loose, self.reported);
  }
};

struct EdgeRecord {
  Index node[2] = {kNone, kNone};
  Index next[2] = {kNone, kNone}, prev[2] = {kNone, kNone};
  Index at = kNone;  // the edge of level 0, or of the span tree
  std::uint32_t generation = 0;
  EdgePlace place = EdgePlace::kNew;
  bool alive = false;
  bool binds = false;

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.node, self.next, self.prev, self.at, self.generation, self.place, self.alive,
            self.binds);
  }
};

// A chain: from node[0] to node[1].
template <typename G>
struct ChainRecord {
  Index node[2] = {kNone, kNone};
  Index root = kNone;        // its spans
  Index level_edge = kNone;  // kNone: an end is free
  G T_kept_free;             // where one end is free: the measurements composed
  float length = 0;          // then, in m
  double chi2 = 0;           // of the level edge where the chain was last linearized
  std::uint32_t stamp = 0;   // of the last ForEachMoved that looked at it
  bool alive = false;
  bool changed = false;   // is in changed_
  bool is_new = false;    // holds an edge that was not there before
  bool composed = false;  // T_kept_free is up to date
  bool lags = false;      // could not follow its ends when they moved: to be cut

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.node, self.root, self.level_edge, self.T_kept_free, self.length, self.chi2,
            self.stamp, self.alive, self.changed, self.is_new, self.composed, self.lags);
  }
};

// An edge that CondensedGraph::Restructure has put on level 0 of the hierarchy.
struct PlacedEdge {
  Index edge = kNone;   // of level 0
  bool is_new = false;  // a measurement that was not there before, not a part of a chain

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.edge, self.is_new);
  }
};

// How an edge goes on to what it measures.
struct Pull {
  int left = 0;      // degrees after the present one, at most
  double reach = 0;  // m of a degree

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.left, self.reach);
  }
};

template <typename G>
struct PulledEdge {
  ceres_costs::RelativePoseTerm<G> measured;
  Pull pull;

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.measured, self.pull);
  }
};

// A stretch of a chain as a factor between two nodes (kCoarseConvention), what is between them
// eliminated.
template <typename G>
struct Stretch {
  Index node[2] = {kNone, kNone};
  ceres_costs::RelativePoseTerm<G> term;
};

}  // namespace hpgo
