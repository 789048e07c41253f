// The condensed graph: edges of level 0 that pull a part of the way to what they measure.

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

template <typename G>
bool CondensedGraph<G>::CanBePulled(Index e) const {
  const Edge& edge = edges_[e];
  if (edge.place != Place::kLevel || edge.node[0] == kNone || !edge.binds) return false;
  return !Binds(FactorOf(e));
}

// Groups stay as they are: it is the same edge.
template <typename G>
void CondensedGraph<G>::SetTermOfLevel(Index e, const ceres_costs::RelativePoseTerm<G>& term) {
  const Index level_edge = edges_[e].at;
  hierarchy_.UpdateEdge(level_edge, term, hierarchy_.level(0).edges[level_edge].weight);
}

template <typename G>
void CondensedGraph<G>::PullTowards(Index e, const G& T_i_j, const Pull& pull) {
  ceres_costs::RelativePoseTerm<G> term = *FactorOf(e).term;
  pulled_.emplace(e, PulledEdge<G>{term, pull}).first->second.pull = pull;  // measures what it did
  term.measurement = T_i_j;
  SetTermOfLevel(e, term);
}

template <typename G>
void CondensedGraph<G>::EndPull(Index e) {
  const auto it = pulled_.find(e);
  if (it == pulled_.end()) return;
  SetTermOfLevel(e, it->second.measured);
  pulled_.erase(it);
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
