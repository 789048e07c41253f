#include "hpgo/schedule/stress.h"

#include <algorithm>
#include <cmath>

#include "hpgo/hierarchy/coarse_edge.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

StressThresholds StressThresholds::FromMean(double mean_chi2, double relative) {
  constexpr double kFloor = 1e-14;  // a graph that fits exactly leaves only rounding
  StressThresholds thresholds;
  thresholds.tau = std::max(relative * mean_chi2, kFloor);
  thresholds.dirty = thresholds.pending = static_cast<float>(0.5 * std::sqrt(thresholds.tau));
  return thresholds;
}

StressThresholds StressThresholds::MergingAll(CoarseEdges coarse_edges) const {
  StressThresholds thresholds = *this;
  if (coarse_edges == CoarseEdges::kGalerkin) thresholds.dirty = 0;  // others hold measurements
  return thresholds;
}

template <typename G>
double NodeStress(int l, Index n, int max_edges, Hierarchy<G>* hierarchy, int* looked_at) {
  Level<G>& level = hierarchy->mutable_level(l);
  if (level.nodes[n].fixed > 0) return 0;
  ceres_costs::QuadraticModel<G> sum, model, moved;
  int count = 0;
  ForEachEdge(level, n, [&](Index e, Index other) {
    if (count >= max_edges) return;
    ++count;
    const LevelEdge& edge = level.edges[e];
    if (l > 0 && !edge.merged) hierarchy->Merge(l, e);
    const G Y = hierarchy->RelativePose(l, edge.node[0], edge.node[1]);
    if (l == 0) hierarchy->Refresh(e, Y);
    if (!LinearizeFactor(hierarchy->FactorOf(l, e), other == kNone, Y, &model)) return;
    if (edge.node[1] == n) {
      sum.A += model.A;
      sum.b += model.b;
    } else {
      TransportModel(Y.Inverse(), model, &moved);  // J_i = -J_j Ad(Y^-1)
      sum.A += moved.A;
      sum.b -= moved.b;
    }
  });
  if (looked_at != nullptr) *looked_at += count;
  return sum.b.dot(SemiDefiniteInverse<G>(sum.A).Times(sum.b));
}

template <typename G>
void AddPending(int l, Index edge, double amount, const StressThresholds& thresholds,
                Hierarchy<G>* hierarchy) {
  const float pending = hierarchy->level(l).edges[edge].pending + static_cast<float>(amount);
  hierarchy->SetPending(l, edge, pending, thresholds.pending);
}

template <typename G>
void HandDown(int l, Index edge, double amount, const StressThresholds& thresholds,
              Hierarchy<G>* hierarchy) {
  if (l == 0 || amount == 0) return;
  const LevelEdge& record = hierarchy->level(l).edges[edge];
  const double share = amount / std::sqrt(static_cast<double>(record.num_children));
  const Level<G>& below = hierarchy->level(l - 1);
  for (Index c = record.first_child; c != kNone; c = below.edges[c].next_sibling) {
    AddPending(l - 1, c, share, thresholds, hierarchy);
  }
}

template <typename G>
void TellParent(int l, Index edge, double amount, const StressThresholds& thresholds,
                Hierarchy<G>* hierarchy) {
  const Index parent = hierarchy->level(l).edges[edge].parent;
  if (parent != kNone) NoteChanged(l + 1, parent, amount, thresholds, hierarchy);
}

template <typename G>
void NoteChanged(int l, Index edge, double amount, const StressThresholds& thresholds,
                 Hierarchy<G>* hierarchy) {
  float& changed = hierarchy->mutable_level(l).edges[edge].changed;
  changed += static_cast<float>(amount);
  if (changed > thresholds.dirty) hierarchy->MarkDirty(l, edge);
}

template <typename G>
FoundWork FindWork(int l, int max_edges, int max_degree, const StressThresholds& thresholds,
                   Hierarchy<G>* hierarchy) {
  FoundWork work;
  Level<G>& level = hierarchy->mutable_level(l);
  const std::uint32_t calm = hierarchy->NewStamp();  // nodes that this search has looked at
  while (work.examined < max_edges && !level.pending.empty()) {
    const Index e = level.pending.Largest();
    const float pending = level.edges[e].pending;
    if (pending <= thresholds.pending) break;  // the threshold has risen since
    ++work.examined;
    HandDown(l, e, pending, thresholds, hierarchy);
    hierarchy->SetPending(l, e, 0, thresholds.pending);
    for (int side = 0; side < 2; ++side) {
      const Index end = work.ends[side] = level.edges[e].node[side];
      if (end == kNone || work.found || level.nodes[end].stamp == calm) continue;
      level.nodes[end].stamp = calm;
      work.found = NodeStress(l, end, max_degree, hierarchy, &work.examined) > thresholds.tau;
    }
    if (work.found) break;
  }
  return work;
}

template <typename G>
double LargestPending(int l, const Hierarchy<G>& hierarchy) {
  const Level<G>& level = hierarchy.level(l);
  return level.pending.empty() ? 0 : level.edges[level.pending.Largest()].pending;
}

#define HPGO_INSTANTIATE(G)                                                              \
  template double NodeStress(int, Index, int, Hierarchy<G>*, int*);                      \
  template void AddPending(int, Index, double, const StressThresholds&, Hierarchy<G>*);  \
  template void HandDown(int, Index, double, const StressThresholds&, Hierarchy<G>*);    \
  template void TellParent(int, Index, double, const StressThresholds&, Hierarchy<G>*);  \
  template void NoteChanged(int, Index, double, const StressThresholds&, Hierarchy<G>*); \
  template FoundWork FindWork(int, int, int, const StressThresholds&, Hierarchy<G>*);    \
  template double LargestPending(int, const Hierarchy<G>&);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
