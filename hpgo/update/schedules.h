// Which windows an update opens.
#pragma once

#include <vector>

#include "hpgo/schedule/sweep.h"
#include "hpgo/update/news.h"
#include "hpgo/update/window_sizes.h"
#include "hpgo/update/window_step.h"

namespace hpgo {

// What an update works with.
template <typename G>
struct UpdateTools {
  const OptimizerOptions& options;
  CondensedGraph<G>& graph;
  WindowStep<G>& step;
  WindowSizes& sizes;
  Sweep& sweep;
};

// What it has decided before anything is solved. Never changes.
struct UpdatePlan {
  const Budget& budget;
  const StressThresholds& thresholds;
  const News& news;
  double far_off;  // chi2 that counts as far from the optimum
  // The cost that the caller sees. Not in an update without changes, but for Refine, which goes on
  // until it has fallen.
  bool may_rise = true;
};

// Computes the coarse edges anew whose children have changed, bottom to top, as far as the budget
// goes.
template <typename G>
void MergeDirty(const UpdateTools<G>& tools, const UpdatePlan& plan, UpdateReport* report);

struct ScheduleResult {
  bool at_rest = false;  // nothing is left
  double decrease = 0;   // of the windows' costs, summed
  int solved_nodes = 0;  // free in them
};

// Of an update's sweep: those of the options, or, where time bounds it, none, and no level waits.
SweepLimits SweepLimitsOf(const OptimizerOptions& options, const Budget& budget);

// Windows where the predicted decrease of chi2 is worth it. Where the cost must not rise those
// that would raise it are left to the next update.
template <typename G>
ScheduleResult RunStressSchedule(const UpdateTools<G>& tools, const UpdatePlan& plan,
                                 UpdateReport* report);

// The whole top, to convergence, and a window on every lower level, whether it is stressed or not:
// around the new edges or the newest node.
template <typename G>
void RunFixedSchedule(const UpdateTools<G>& tools, const UpdatePlan& plan, Index newest,
                      UpdateReport* report);

// The top alone, in so many iterations at most.
template <typename G>
void SolveTop(const UpdateTools<G>& tools, const UpdatePlan& plan, int iterations,
              UpdateReport* report);

// The graph as its caller sees it, every chain opened: for poses that are far off, where chains
// would have to bend by more than their models can say. A sparse solve of all nodes.
template <typename G>
void SolveOpened(const UpdateTools<G>& tools, const UpdatePlan& plan, double max_seconds,
                 UpdateReport* report);

// How a solve of the whole graph ended: kStuck where it gains no more though it is at no minimum
// that the solver knows, or fails; kCutShort where it would have gone on.
enum class WholeSolve { kConverged, kStuck, kCutShort };

// The whole graph over its kept nodes, to convergence. One iteration is made in any time.
template <typename G>
WholeSolve SolveWholeGraph(const UpdateTools<G>& tools, const UpdatePlan& plan,
                           UpdateReport* report);

}  // namespace hpgo
