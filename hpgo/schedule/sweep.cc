#include "hpgo/schedule/sweep.h"

#include <algorithm>

namespace hpgo {

bool Sweep::Run(int num_levels, const SweepLimits& limits, double threshold,
                const SweepActions& actions) {
  const int top = num_levels - 1;
  int level = top;
  if (start_ >= 0 && start_ < top &&
      actions.largest_pending(top) <= actions.largest_pending(start_)) {
    level = start_;
  }
  start_ = -1;
  int windows = 0;
  std::vector<int> served(num_levels, 0);
  std::vector<bool> rests(num_levels, false);  // had no work when it was asked
  const auto may_be_served = [&](int k) {
    return !rests[k] && served[k] < limits.max_windows_per_level;
  };
  for (;; level = level == 0 ? top : level - 1) {
    double largest = -1;  // of those that may be served
    for (int k = 0; k < num_levels; ++k) {
      if (may_be_served(k)) largest = std::max(largest, actions.largest_pending(k));
    }
    if (largest < 0) return std::find(rests.begin(), rests.end(), false) == rests.end();
    const bool waits = actions.largest_pending(level) < limits.least_share * largest;
    if (waits || !may_be_served(level)) continue;
    if (windows >= limits.max_windows || (actions.stop && actions.stop(level))) break;
    if (const int worth = actions.serve(level); worth > 0) {
      ++served[level];
      windows += worth;
      rests.assign(num_levels, false);
    } else {
      rests[level] = true;
    }
  }
  for (int k = 0; k < num_levels; ++k) {
    const int next = (level - k + num_levels) % num_levels;
    if (actions.largest_pending(next) <= threshold) continue;
    start_ = next;
    break;
  }
  return false;
}

}  // namespace hpgo
