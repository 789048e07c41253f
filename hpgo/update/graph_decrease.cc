#include "hpgo/update/graph_decrease.h"

#include <algorithm>
#include <cmath>

#include "hpgo/update/constants.h"
#include "hpgo/update/motion.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

struct AskedEdge {
  std::size_t edge;  // of the window
  double may_miss;   // chi2
};

// Those that may miss `least` or more are asked, as long as there are edges left to look at.
template <typename G>
double AskedDecrease(const std::vector<AskedEdge>& edges, double least, int left,
                     const Window<G>& window, const Hierarchy<G>& hierarchy) {
  double decrease = 0;
  for (const AskedEdge& edge : edges) {
    int none = 0;
    const bool is_asked = !(edge.may_miss < least);
    decrease += hierarchy.CostDecrease(window.level(), window.edges()[edge.edge],
                                       window.RelativePoseBefore(edge.edge),
                                       window.RelativePose(edge.edge), is_asked ? &left : &none);
  }
  return decrease;
}

}  // namespace

template <typename G>
double MissedPull(const LevelEdge& edge, const G& before, const G& after, double change) {
  return 2 * HalfRotation(before.Between(after)) * (change + std::sqrt(std::max(0.f, edge.chi2)));
}

template <typename G>
double GraphDecrease(const Window<G>& window, double promised, const std::vector<double>& changes,
                     const Hierarchy<G>& hierarchy, Asking asking) {
  std::vector<AskedEdge> edges;
  double may_miss = 0;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const LevelEdge& edge = hierarchy.level(window.level()).edges[window.edges()[k]];
    const double pull =
        MissedPull(edge, window.RelativePoseBefore(k), window.RelativePose(k), changes[k]);
    edges.push_back({k, changes[k] * pull});
    may_miss += edges.back().may_miss;
  }
  if (asking == Asking::kAll) {
    std::sort(edges.begin(), edges.end(),
              [](const AskedEdge& a, const AskedEdge& b) { return a.may_miss > b.may_miss; });
    return AskedDecrease(edges, 0, kMostOfAllAsked, window, hierarchy);
  }
  const double most = kShareMissedUnasked * promised;
  if (may_miss < most) return promised;
  const double of_some =
      AskedDecrease(edges, most / edges.size(), kMostAskedBelow, window, hierarchy);
  if (!(of_some > 0) || promised - of_some < may_miss) return of_some;
  return AskedDecrease(edges, 0, kMostAskedBelow, window, hierarchy);
}

#define HPGO_INSTANTIATE(G)                                                           \
  template double MissedPull(const LevelEdge&, const G&, const G&, double);           \
  template double GraphDecrease(const Window<G>&, double, const std::vector<double>&, \
                                const Hierarchy<G>&, Asking);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
