// The order in which the levels are served. A pure decision: knows neither poses nor solvers.
#pragma once

#include <functional>
#include <vector>

namespace hpgo {

struct SweepLimits {
  int max_windows = 0;  // M: windows an update, the top's solve among them; the caller's to choose
  int max_windows_per_level = 2;
  // Of the largest pending of the levels that may be served, below which one waits: pending is the
  // root of what a level gains, so that a window there would gain less than a hundredth.
  double least_share = 0.1;
};

// What the sweep asks and orders.
struct SweepActions {
  // Looks for work on a level and does it: the number of usual windows it was worth, 0 if there was
  // none.
  std::function<int(int level)> serve;
  // The largest pending of a level, in sqrt(chi2).
  std::function<double(int level)> largest_pending;
  // Optional: true ends the sweep before this level is served (a time limit, cancellation).
  std::function<bool(int level)> stop;
};

// Serves levels top to bottom, in turns, until none finds work or a limit is hit. A level may be
// served unless it had no work since the last window, or has had its share. Remembers where a limit
// of the whole hit it: always starting at the top would starve the lower levels. Not synchronized.
class Sweep {
 public:
  // `threshold`: pending below it, in sqrt(chi2), is no reason to begin at a level.
  // Returns true if it came to rest: no level had work left.
  bool Run(int num_levels, const SweepLimits& limits, double threshold,
           const SweepActions& actions);
  // The next one begins at the top, wherever a limit hit the last one.
  void StartAtTop() { start_ = -1; }

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.start_);
  }

 private:
  int start_ = -1;  // the level the next update begins with; -1: the top
};

}  // namespace hpgo
