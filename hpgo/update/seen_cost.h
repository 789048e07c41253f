// The cost as the caller sees it, where edges pull elsewhere than to what they measure.
#pragma once

#include <vector>

#include "hpgo/chains/condensed_graph.h"
#include "hpgo/solve/window.h"

namespace hpgo {

// What a step is judged by besides its window's cost. A value.
template <typename G>
struct SeenCost {
  struct PulledEdge {
    Index level_edge;  // on level 0
    ceres_costs::RelativePoseTerm<G> measured;
  };
  std::vector<PulledEdge> pulled;
  bool may_rise = true;
};

// Of a graph; what pulls elsewhere counts where the cost must not rise.
template <typename G>
SeenCost<G> SeenCostOf(const CondensedGraph<G>& graph, bool may_rise);

// By how much more the pulled edges' own costs fall, in chi2, when the window's poses go to where
// its step says, than those of where they pull.
template <typename G>
double SeenAside(const SeenCost<G>& seen, const Window<G>& window, const Hierarchy<G>& hierarchy);

}  // namespace hpgo
