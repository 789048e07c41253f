#include "hpgo/solve/over_correction.h"

#include <algorithm>

namespace hpgo {
namespace {

// Below 2, the groups' own cost falls nevertheless.
constexpr double kMost = 1.7;

}  // namespace

template <typename G>
double OverCorrection<G>::Factor(const Window<G>& window, const Hierarchy<G>& hierarchy) {
  const int l = window.level();
  if (static_cast<int>(levels_.size()) < hierarchy.num_levels() + 1) {
    levels_.resize(hierarchy.num_levels() + 1);
  }
  // The sums of d'm and m'm over motions d of the window and m remembered of the same node, and of
  // its group.
  double own = 0, own_sq = 0, groups = 0, groups_sq = 0;
  const auto add = [](const Motions& last, Index node, const typename G::Vector& d, double* along,
                      double* squared) {
    const auto found = last.find(node);
    if (found == last.end()) return;
    *along += d.dot(found->second);
    *squared += found->second.squaredNorm();
  };
  LevelMotions& level = levels_[l];
  for (int k = 0; k < window.num_free(); ++k) {
    const Index n = window.nodes()[k];
    add(level.last, n, window.Displacement(k), &own, &own_sq);
    add(levels_[l + 1].last, hierarchy.level(l).nodes[n].parent, window.Displacement(k), &groups,
        &groups_sq);
  }
  if (own_sq > 0) {
    // Of a motion that needs f times its solution, f_last times the solution leave 1 - f_last / f,
    // of which the next solution finds 1 / f: the share of the last motion that it adds is
    // s = (f - f_last) / (f f_last).
    const double left = 1 - own / own_sq * level.factor;
    level.factor = left > level.factor / kMost ? level.factor / left : kMost;
  } else if (groups_sq > 0) {
    level.factor = 1 + groups / groups_sq;
  }
  level.factor = std::clamp(level.factor, 1., kMost);
  for (int k = 0; k < window.num_free(); ++k) {
    level.last[window.nodes()[k]] = level.factor * window.Displacement(k);
  }
  return level.factor;
}

template class OverCorrection<ceres_costs::SE2>;
template class OverCorrection<ceres_costs::SE3>;

}  // namespace hpgo
