#include "hpgo/update/news.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/factor_term.h"
#include "hpgo/update/constants.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// Just above what is worth a look: the look decides.
template <typename G>
void PutUp(int l, Index edge, const StressThresholds& thresholds, Hierarchy<G>* hierarchy) {
  const float pending = hierarchy->level(l).edges[edge].pending;
  hierarchy->SetPending(l, edge, std::max(pending, 2 * thresholds.pending), thresholds.pending);
}

// The edges of a node, or of the end of its chain, on every level.
template <typename G>
void Disturb(Index n, const StressThresholds& thresholds, CondensedGraph<G>* graph) {
  Hierarchy<G>& hierarchy = graph->hierarchy();
  const Index kept = graph->KeptNear(n);
  if (kept == kNone) return;
  Index node = graph->LevelNodeOf(kept);
  for (int l = 0; l < hierarchy.num_levels() && node != kNone;
       node = hierarchy.level(l++).nodes[node].parent) {
    int count = 0;
    ForEachEdge(hierarchy.level(l), node, [&](Index e, Index) {
      if (++count <= kMostDisturbedEdges) PutUp(l, e, thresholds, &hierarchy);
    });
  }
}

}  // namespace

template <typename G>
News NewsOf(const CondensedGraph<G>& graph, const std::vector<Index>& changed) {
  News news;
  for (const Index edge : changed) {
    const Index e = graph.LevelEdgeOf(edge);
    if (e != kNone) news.edges.push_back(e);
  }
  return news;
}

template <typename G>
News FindNews(const CondensedGraph<G>& graph, const std::vector<Index>& changed) {
  News news = NewsOf(graph, changed);
  for (const PlacedEdge& placed : graph.placed()) {
    (placed.is_new ? news.edges : news.reshaped).push_back(placed.edge);
  }
  std::sort(news.edges.begin(), news.edges.end());
  news.edges.erase(std::unique(news.edges.begin(), news.edges.end()), news.edges.end());
  return news;
}

template <typename G>
bool IsFarOff(const std::vector<Index>& edges, const Hierarchy<G>& hierarchy) {
  return std::any_of(edges.begin(), edges.end(), [&](Index e) {
    const LevelEdge& edge = hierarchy.level(0).edges[e];
    if (edge.node[0] == kNone) return false;
    const ceres_costs::RelativePoseTerm<G>& term = *hierarchy.FactorOf(0, e).term;
    const bool measures_rotation =
        term.information.Dense().diagonal().template tail<G::kRotationDof>().maxCoeff() > 0;
    return measures_rotation &&
           IsTwisted(term.measurement, hierarchy.RelativePose(0, edge.node[0], edge.node[1]));
  });
}

template <typename G>
std::vector<Index> PendingEdges(const StressThresholds& thresholds, const Hierarchy<G>& hierarchy) {
  const Level<G>& level = hierarchy.level(0);
  std::vector<Index> pending;
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    if (level.edges[e].alive && level.edges[e].pending > thresholds.pending) pending.push_back(e);
  }
  return pending;
}

template <typename G>
Index QueueNews(const News& news, const std::vector<Index>& disturbed,
                const StressThresholds& thresholds, CondensedGraph<G>* graph) {
  Hierarchy<G>& hierarchy = graph->hierarchy();
  Level<G>& level = hierarchy.mutable_level(0);
  Index bad_edge = kNone;
  for (const Index e : news.reshaped) {
    level.edges[e].merged = true;
    PutUp(0, e, thresholds, &hierarchy);
  }
  for (const Index e : news.edges) {
    LevelEdge& edge = level.edges[e];
    edge.merged = true;
    const double chi2 = FactorCost(hierarchy.FactorOf(0, e), edge.node[0] == kNone,
                                   hierarchy.RelativePose(0, edge.node[0], edge.node[1]));
    if (std::isfinite(chi2)) {
      AddPending(0, e, std::sqrt(chi2), thresholds, &hierarchy);
    } else {
      bad_edge = e;
    }
  }
  for (const Index node : disturbed) {
    if (graph->IsNode(node)) Disturb(node, thresholds, graph);
  }
  return bad_edge;
}

template <typename G>
void QueueAll(const StressThresholds& thresholds, Hierarchy<G>* hierarchy) {
  for (int l = 0; l < hierarchy->num_levels(); ++l) {
    const Level<G>& level = hierarchy->level(l);
    for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
      if (level.edges[e].alive) PutUp(l, e, thresholds, hierarchy);
    }
  }
}

template <typename G>
void QueueRefreshed(const StressThresholds& thresholds, Hierarchy<G>* hierarchy) {
  for (const auto& [e, change] : hierarchy->TakeRefreshed()) {
    if (!hierarchy->level(0).edges[e].alive) continue;
    AddPending(0, e, change, thresholds, hierarchy);
    TellParent(0, e, change, thresholds, hierarchy);
  }
}

#define HPGO_INSTANTIATE(G)                                                                 \
  template News FindNews(const CondensedGraph<G>&, const std::vector<Index>&);              \
  template News NewsOf(const CondensedGraph<G>&, const std::vector<Index>&);                \
  template bool IsFarOff(const std::vector<Index>&, const Hierarchy<G>&);                   \
  template std::vector<Index> PendingEdges(const StressThresholds&, const Hierarchy<G>&);   \
  template Index QueueNews(const News&, const std::vector<Index>&, const StressThresholds&, \
                           CondensedGraph<G>*);                                             \
  template void QueueAll(const StressThresholds&, Hierarchy<G>*);                           \
  template void QueueRefreshed(const StressThresholds&, Hierarchy<G>*);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
