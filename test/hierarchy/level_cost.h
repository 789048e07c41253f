// What a level costs, for the tests of what is done to it.
#pragma once

#include "ceres_costs/factor_term.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

template <typename G>
double CostOfLevel(const Hierarchy<G>& hierarchy, int l) {
  double sum = 0;
  const Level<G>& level = hierarchy.level(l);
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    const LevelEdge& edge = level.edges[e];
    if (!edge.alive) continue;
    sum += FactorCost(hierarchy.FactorOf(l, e), edge.node[0] == kNone,
                      hierarchy.RelativePose(l, edge.node[0], edge.node[1]));
  }
  return sum;
}

}  // namespace hpgo
