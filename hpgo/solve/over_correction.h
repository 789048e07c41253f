// How far beyond its solution a window of a coarse level should go.
#pragma once

#include <unordered_map>
#include <vector>

#include "hpgo/solve/window.h"

namespace hpgo {

// Rigid motions of groups bend the graph between them only, which costs more than a smooth motion
// of their members, the more the higher the level. So the solution of a coarse level falls short of
// a smooth motion; multigrid with aggregates over-corrects by a constant factor (Braess 1995). Here
// the factor is learnt, as groups that hang on few edges need none: from how far the same nodes
// still go the next time, and for a level's first window from how far it goes on with the motions
// of the groups above. Not synchronized.
template <typename G>
class OverCorrection {
 public:
  // For another motion of the graph.
  void Forget() { levels_.clear(); }
  // By what to stretch the motions of a solved window above level 0: 1 to 1.7; remembers them as
  // stretched. O(window).
  double Factor(const Window<G>& window, const Hierarchy<G>& hierarchy);

 private:
  using Motions = std::unordered_map<Index, typename G::Vector>;  // translations, in the world
  struct LevelMotions {
    double factor = 1;
    Motions last;  // by node
  };

  std::vector<LevelMotions> levels_;
};

extern template class OverCorrection<ceres_costs::SE2>;
extern template class OverCorrection<ceres_costs::SE3>;

}  // namespace hpgo
