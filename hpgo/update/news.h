// The first step of an update: what is new, and where it is.
#pragma once

#include <vector>

#include "hpgo/chains/condensed_graph.h"
#include "hpgo/schedule/stress.h"

namespace hpgo {

// What a caller has changed since the last update. Nodes and edges are indices of the graph.
struct Changes {
  int num_nodes = 0;             // added
  int num_edges = 0;             // added or changed, those that went again among them
  std::vector<Index> edges;      // those that are there
  std::vector<Index> disturbed;  // nodes that lost an edge, or what held them
  Index newest = kNone;          // node
  static Changes None(Index newest) {
    Changes none;
    none.newest = newest;
    return none;
  }
  bool empty() const { return num_nodes == 0 && num_edges == 0 && disturbed.empty(); }
};

// The same in the hierarchy.
struct News {
  std::vector<Index> edges;     // of level 0, new or changed
  std::vector<Index> reshaped;  // edges of level 0 that were there in another form
};

// Once the graph is restructured and grouped: what that has placed, and edges that have changed.
template <typename G>
News FindNews(const CondensedGraph<G>& graph, const std::vector<Index>& changed);
// Of edges that have changed since.
template <typename G>
News NewsOf(const CondensedGraph<G>& graph, const std::vector<Index>& changed);

// Whether one of these edges of level 0 is turned against its measurement by more than a
// linearization can reach.
template <typename G>
bool IsFarOff(const std::vector<Index>& edges, const Hierarchy<G>& hierarchy);

// The edges of level 0 that are up for examination.
template <typename G>
std::vector<Index> PendingEdges(const StressThresholds& thresholds, const Hierarchy<G>& hierarchy);

// Puts it, and what is disturbed, up for examination. Returns an edge of level 0 whose cost cannot
// be evaluated at the estimate, kNone if there is none: it is left out.
template <typename G>
Index QueueNews(const News& news, const std::vector<Index>& disturbed,
                const StressThresholds& thresholds, CondensedGraph<G>* graph);

// Puts every edge up for examination.
template <typename G>
void QueueAll(const StressThresholds& thresholds, Hierarchy<G>* hierarchy);

// Chains that were linearized anew pull otherwise than before.
template <typename G>
void QueueRefreshed(const StressThresholds& thresholds, Hierarchy<G>* hierarchy);

}  // namespace hpgo
