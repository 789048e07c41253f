#include "hpgo/update/chi2_mean.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/factor_term.h"
#include "hpgo/update/constants.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
void Chi2Mean::Sample(const Hierarchy<G>& hierarchy, int new_edges) {
  constexpr std::uint32_t kStride = 2654435761u;  // of the golden ratio: even over any range
  const Level<G>& level = hierarchy.level(0);
  if (level.num_edges == 0) return;
  const int count = std::min(kSamplesPerUpdate + new_edges, kMostSamplesPerUpdate);
  for (int k = 0; k < count; ++k) {
    next_ += kStride;
    const Index e = static_cast<Index>((std::uint64_t{next_} * level.edges.size()) >> 32);
    const LevelEdge& edge = level.edges[e];
    if (!edge.alive || !edge.merged) continue;
    double chi2 = FactorCost(hierarchy.FactorOf(0, e), edge.node[0] == kNone,
                             hierarchy.RelativePose(0, edge.node[0], edge.node[1]));
    if (!std::isfinite(chi2)) continue;
    chi2 = std::min(chi2, std::max<double>(G::kDof, kMostMeansOfASample * mean_));
    num_samples_ = std::min(num_samples_ + 1, kMeanMemory);
    mean_ += (chi2 - mean_) / num_samples_;
  }
}

template void Chi2Mean::Sample(const Hierarchy<SE2>&, int);
template void Chi2Mean::Sample(const Hierarchy<SE3>&, int);
template void Chi2Mean::Sample(const Hierarchy<YawPose>&, int);

}  // namespace hpgo
