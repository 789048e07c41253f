// The part of a map that bears most on a few of its nodes, as a problem of a bounded size.
#pragma once

#include <vector>

#include "hpgo/chains/condensed_graph.h"
#include "hpgo/graph/status.h"
#include "hpgo/solve/subproblem.h"
#include "hpgo/solve/window.h"

namespace hpgo {

// Kept nodes with chains as factors, and the nodes asked for, their chains cut there. Valid until
// the graph changes.
template <typename G>
struct Neighborhood {
  Window<G> window;
  std::vector<Stretch<G>> stretches;  // what factors of cut chains point to
  std::vector<int> indices;           // of the nodes asked for, in problem().poses
  bool whole = false;                 // nothing of their component is missing

  Subproblem<G>& problem() { return window.subproblem(); }
};

// The kept nodes around one or two nodes, and those around the shortest way from the first to the
// second, or of a single one to what holds its component: breadth-first until there are max_nodes,
// or all, or the way itself where that is longer. What lies beyond is left out, not held: less is
// known in the neighborhood than in the map, and the covariances are upper bounds, up to where
// chains are linearized. Two nodes without anything that holds them: the first of the problem is
// held, which their relative covariance does not see.
//
// O(max_nodes + way): the way is found from the top level down, on each level within the groups of
// the level above. kNoSolution where there is none, or for a node that has no edge since the last
// update.
template <typename G>
Status FindNeighborhood(const std::vector<Index>& nodes, int max_nodes, CondensedGraph<G>* graph,
                        Neighborhood<G>* neighborhood);

}  // namespace hpgo
