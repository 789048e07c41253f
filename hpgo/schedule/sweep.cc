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
  std::vector<int> served(num_levels, 0);
  int windows = 0, idle = 0;                   // idle: levels in a row without work
  std::vector<bool> rests(num_levels, false);  // had no work when it was asked
  bool skipped = false;                        // a level was passed over that may have work
  while (idle < num_levels) {
    const bool stop = actions.stop && actions.stop(level);
    if (windows >= limits.max_windows || stop) {
      for (int k = 0; k < num_levels; ++k) {
        const int next = (level - k + num_levels) % num_levels;
        if (actions.largest_pending(next) <= threshold) continue;
        start_ = next;
        return false;
      }
      return false;
    }
    double largest = 0;
    for (int k = 0; k < num_levels; ++k) {
      if (!rests[k]) largest = std::max(largest, actions.largest_pending(k));
    }
    const double pending = actions.largest_pending(level);
    const bool waits = pending > threshold && pending < limits.least_share * largest;
    if (waits || served[level] >= limits.max_windows_per_level) {
      skipped = true;
      ++idle;
    } else if (const int worth = actions.serve(level); worth > 0) {
      ++served[level];
      windows += worth;
      idle = 0;
      rests.assign(num_levels, false);
    } else {
      rests[level] = true;
      ++idle;
    }
    level = level == 0 ? top : level - 1;
  }
  return !skipped;
}

}  // namespace hpgo
