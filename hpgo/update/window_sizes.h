// How large windows may be.
#pragma once

#include <vector>

#include "hpgo/solve/window.h"
#include "hpgo/update/budget.h"
#include "hpgo/update/options.h"

namespace hpgo {

// At the options' size where they bound an update; where time does, as large as a share of it
// allows by what recent windows took: of the same work, fewer and larger windows carry a correction
// further. All fields are learnt from windows. Not synchronized.
class WindowSizes {
 public:
  explicit WindowSizes(const OptimizerOptions& options) : options_(options) {}

  // Of the next window on a level.
  WindowLimits Next(int l, const Budget& budget) const;
  // How many windows of the options' size one of so many nodes and edges is.
  double Worth(int num_nodes, std::size_t num_edges) const;
  // What a window of that worth takes on a level, in seconds, by recent ones there or, where there
  // was none yet, on the slowest level; 0 without any.
  double SecondsOf(double worth, int l) const;
  // After a solve.
  void Learn(int l, double worth, double seconds, bool damped);

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.largest_, self.seconds_);
  }

 private:
  OptimizerOptions options_;
  double largest_ = 1;           // over the options' size
  std::vector<double> seconds_;  // by level, at the options' size; 0: none yet
};

}  // namespace hpgo
