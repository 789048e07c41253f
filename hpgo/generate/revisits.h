// Where a path comes back to a place it has been at.
#pragma once

#include <vector>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"

namespace hpgo {

struct RevisitOptions {
  double radius = 1.5;     // m between the two poses, > 0
  double min_travel = 10;  // m of way between them, more than radius
  int max_per_node = 2;    // the older passes a node is paired with, the nearest first
};

struct Revisit {
  int newer = 0;
  int older = 0;  // < newer
};

// In the order of `newer`. Of one pass through a place (poses within 3 radii of way) only the
// nearest pose is paired. O(N) by a spatial hash; a place keeps its first 64 poses, so that a robot
// that stands still costs no more.
template <typename G>
std::vector<Revisit> FindRevisits(const std::vector<G>& poses, const RevisitOptions& options);

}  // namespace hpgo
