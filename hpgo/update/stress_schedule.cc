#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "hpgo/update/constants.h"
#include "hpgo/update/schedules.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// One update's; thrown away after it.
template <typename G>
class StressSchedule {
 public:
  StressSchedule(const UpdateTools<G>& tools, const UpdatePlan& plan, UpdateReport* report)
      : tools_(tools),
        plan_(plan),
        hierarchy_(tools.graph.hierarchy()),
        seen_(SeenCostOf(tools.graph, plan.may_rise)),
        report_(report) {}

  ScheduleResult Run();

 private:
  double Pending(int l) const { return LargestPending(l, hierarchy_); }
  // Of the window that is built.
  double Worth() const {
    const Window<G>& window = tools_.step.window();
    return tools_.sizes.Worth(window.num_free(), window.edges().size());
  }
  bool IsStopped(int l) const;
  FoundWork Search(int l);
  int Serve(int l, int max_solves);
  int SolveToRest(double worth, int max_solves, double* total_seconds);
  void NoteRefused();
  void LookAgain();

  const UpdateTools<G>& tools_;
  const UpdatePlan& plan_;
  Hierarchy<G>& hierarchy_;
  const SeenCost<G> seen_;
  UpdateReport* report_;
  // Edges of windows whose step was not taken for the sake of the cost that is seen.
  std::vector<std::pair<int, Index>> refused_;  // level, edge
  double decrease_ = 0;                         // so far
  int solved_nodes_ = 0;
};

template <typename G>
bool StressSchedule<G>::IsStopped(int l) const {
  // One window is made at least: else nothing would ever be done in too short a time.
  if (report_->windows + report_->top_solves == 0) return plan_.budget.IsCancelled();
  return plan_.budget.IsStopped() || (Pending(l) > plan_.thresholds.pending &&
                                      plan_.budget.SecondsLeft() < tools_.sizes.SecondsOf(1, l));
}

template <typename G>
FoundWork StressSchedule<G>::Search(int l) {
  const Stopwatch watch(&report_->examine_seconds);
  FoundWork work;
  do {
    work = FindWork(l, tools_.options.max_examined, tools_.options.window_edges, plan_.thresholds,
                    &hierarchy_);
    report_->examined_edges += work.examined;
  } while (!work.found && plan_.budget.IsUncapped() && !plan_.budget.IsStopped() &&
           Pending(l) > plan_.thresholds.pending);
  return work;
}

// Solves the window on level 0 again as long as its last step was far from linear: until it gains
// nothing that counts. Returns the number of solves.
template <typename G>
int StressSchedule<G>::SolveToRest(double worth, int max_solves, double* total_seconds) {
  const Stopwatch watch(total_seconds);
  Window<G>& window = tools_.step.window();
  const std::int64_t visited = tools_.graph.visited_edges();
  const std::size_t changes = tools_.graph.num_changes();
  int solves = 0;
  double before = watch.Elapsed();
  while (true) {
    const StepResult step =
        tools_.step.Solve(tools_.options.window_iterations, std::numeric_limits<double>::infinity(),
                          plan_.thresholds, plan_.budget, seen_);
    Note(step, report_);
    if (step.is_seen_to_rise) NoteRefused();
    decrease_ += step.decrease;
    solved_nodes_ += step.solved_nodes;
    ++solves;
    const double after = watch.Elapsed();
    tools_.sizes.Learn(window.level(), worth, after - before, step.damped);
    before = after;
    const auto in_chains = static_cast<double>(tools_.graph.visited_edges() - visited);
    const double spent =
        solves * std::max(worth, kLeastWorthOfASolve) + in_chains / kVisitedOfAWindow;
    // What such a step has missed is seen by nobody else before the next update.
    double most = max_solves;
    if (step.missed > plan_.far_off) most += tools_.options.max_windows;
    // Chains that did not follow are to be cut first, which the next update does.
    const bool chains_follow = tools_.graph.num_changes() == changes;
    if (!step.is_nonlinear || window.level() > 0 || (solves >= most && spent >= most) ||
        !chains_follow || in_chains > kMostVisited<G> || plan_.budget.IsStopped()) {
      return solves;
    }
    window.Restart();
  }
}

template <typename G>
void StressSchedule<G>::NoteRefused() {
  const Window<G>& window = tools_.step.window();
  for (std::size_t k = 0; k < window.edges().size(); ++k) {
    if (window.IsInterior(k)) refused_.emplace_back(window.level(), window.edges()[k]);
  }
}

// Whoever comes next does.
template <typename G>
void StressSchedule<G>::LookAgain() {
  const float pending = 2 * plan_.thresholds.pending;
  for (const auto& [l, e] : refused_) {
    if (hierarchy_.level(l).edges[e].pending >= pending) continue;
    hierarchy_.SetPending(l, e, pending, plan_.thresholds.pending);
  }
}

// Finds work on a level and does it; 0 if there is none, else how many usual windows it was worth.
template <typename G>
int StressSchedule<G>::Serve(int l, int max_solves) {
  const FoundWork work = Search(l);
  if (!work.found) return 0;
  Window<G>& window = tools_.step.window();
  // Larger only where many components keep the top from shrinking.
  if (l == hierarchy_.num_levels() - 1 && !hierarchy_.IsTooLarge(l, 2)) {
    ++report_->top_solves;
    if (!window.BuildWhole(l, &hierarchy_)) return 1;
    return SolveToRest(Worth(), max_solves, &report_->top_seconds);
  }
  ++report_->windows;
  std::vector<Index> seeds;
  for (const Index end : work.ends) {
    if (end != kNone) seeds.push_back(end);
  }
  if (!window.Build(l, seeds, tools_.sizes.Next(l, plan_.budget), &hierarchy_)) return 1;
  const double worth = Worth();
  const int solves = SolveToRest(worth, max_solves, &report_->window_seconds);
  return std::max(1, static_cast<int>(std::lround(solves * worth)));
}

template <typename G>
ScheduleResult StressSchedule<G>::Run() {
  const int num_levels = hierarchy_.num_levels();
  const SweepLimits limits = SweepLimitsOf(tools_.options, plan_.budget);
  SweepActions actions;
  actions.stop = [&](int l) { return IsStopped(l); };
  actions.largest_pending = [&](int l) { return Pending(l); };
  int previous = num_levels - 1, solves = 0;
  actions.serve = [&](int l) {
    // Windows below have moved what this level's edges were made from; as long as they have not
    // been merged again, windows here could undo it.
    if (l > std::exchange(previous, l)) {
      MergeDirty(tools_, plan_, report_);
      if (IsStopped(l)) return 0;
    }
    if (!hierarchy_.level(l).dirty.empty()) return 0;
    const int worth = Serve(l, std::max(1, limits.max_windows - solves));
    solves += worth;
    return worth;
  };
  bool at_rest = tools_.sweep.Run(num_levels, limits, 2 * plan_.thresholds.pending, actions);
  LookAgain();
  at_rest &= tools_.graph.num_changes() == 0;  // a chain that must not stay one
  // A search or a merge that has done its share may have left some for the next update.
  for (int l = 0; l < num_levels; ++l) {
    at_rest &= Pending(l) <= plan_.thresholds.pending && hierarchy_.level(l).dirty.empty();
  }
  return {at_rest, decrease_, solved_nodes_};
}

}  // namespace

SweepLimits SweepLimitsOf(const OptimizerOptions& options, const Budget& budget) {
  SweepLimits limits;
  limits.max_windows = options.max_windows;
  if (budget.HasTimeLimit()) {
    limits.max_windows = limits.max_windows_per_level = std::numeric_limits<int>::max();
    limits.least_share = 0;  // a damped level may keep its pending as long as there is time
  }
  return limits;
}

template <typename G>
ScheduleResult RunStressSchedule(const UpdateTools<G>& tools, const UpdatePlan& plan,
                                 UpdateReport* report) {
  return StressSchedule<G>(tools, plan, report).Run();
}

template ScheduleResult RunStressSchedule(const UpdateTools<SE2>&, const UpdatePlan&,
                                          UpdateReport*);
template ScheduleResult RunStressSchedule(const UpdateTools<SE3>&, const UpdatePlan&,
                                          UpdateReport*);
template ScheduleResult RunStressSchedule(const UpdateTools<YawPose>&, const UpdatePlan&,
                                          UpdateReport*);

}  // namespace hpgo
