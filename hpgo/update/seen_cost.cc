#include "hpgo/update/seen_cost.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
SeenCost<G> SeenCostOf(const CondensedGraph<G>& graph, bool may_rise) {
  SeenCost<G> seen;
  seen.may_rise = may_rise;
  if (may_rise) return seen;
  for (const auto& [e, pulled] : graph.pulled()) {
    seen.pulled.push_back({graph.LevelEdgeOf(e), pulled.measured});
  }
  return seen;
}

template <typename G>
double SeenAside(const SeenCost<G>& seen, const Window<G>& window, const Hierarchy<G>& hierarchy) {
  double aside = 0;
  for (const typename SeenCost<G>::PulledEdge& edge : seen.pulled) {
    const auto& ends = hierarchy.level(0).edges[edge.level_edge].node;
    const auto poses = window.PosesBetween(ends[0], ends[1]);
    if (!poses) continue;
    const auto& [before, after] = *poses;
    const ceres_costs::FactorTerm<G> pull = hierarchy.FactorOf(0, edge.level_edge);
    ceres_costs::FactorTerm<G> own = pull;
    own.term = &edge.measured;
    aside += FactorCost(own, false, before) - FactorCost(own, false, after);
    aside -= FactorCost(pull, false, before) - FactorCost(pull, false, after);
  }
  return aside;
}

#define HPGO_INSTANTIATE(G)                                        \
  template SeenCost<G> SeenCostOf(const CondensedGraph<G>&, bool); \
  template double SeenAside(const SeenCost<G>&, const Window<G>&, const Hierarchy<G>&);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
