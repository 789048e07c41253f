#include "hpgo/update/updater.h"

#include <limits>
#include <utility>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/update/constants.h"
#include "hpgo/update/motion.h"

namespace hpgo {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
double CostOf(CondensedGraph<G>* graph) {
  double cost = 0;
  graph->ForEachRelativePose([&](Index e, const G& T) {
    cost += FactorCost(graph->FactorOf(e), graph->End(e, 0) == kNone, T);
  });
  return cost;
}

template <typename G>
Updater<G>::Updater(const OptimizerOptions& options, CondensedGraph<G>* graph, LevelEdgeNamer name)
    : options_(options),
      graph_(*graph),
      step_(options.engine, &graph->hierarchy(), std::move(name)),
      sizes_(options) {}

template <typename G>
UpdateReport Updater<G>::Update(const Changes& changes, Mode mode, const UpdateLimits& limits,
                                Gauge<G>* gauge) {
  ResetDepth();
  rest_ = Rest::kNot;
  return Run(changes, mode, Budget(limits), depth_, gauge).report;
}

// What is new -> what is worth a look -> what is solved within the budget. The solves record, edge
// by edge, what they leave to others.
template <typename G>
typename Updater<G>::Step Updater<G>::Run(const Changes& changes, Mode mode, const Budget& budget,
                                          double depth, Gauge<G>* gauge) {
  Step step;
  UpdateReport& report = step.report;
  {
    const Stopwatch total(&report.seconds);
    std::vector<Index> disturbed = changes.disturbed;
    report.new_nodes = changes.num_nodes;
    report.new_edges = changes.num_edges;
    {
      const Stopwatch watch(&report.insert_seconds);
      TakeIn(changes, gauge, &disturbed);
    }
    const G newest_before = PoseOf(changes.newest);
    if (depth == 1) mean_.Sample(graph_.hierarchy(), changes.num_edges);  // else it was measured
    const StressThresholds thresholds = Thresholds(depth);
    graph_.SetTolerance(kChainToleranceOfDirty * thresholds.dirty);
    News news;
    {
      const Stopwatch watch(&report.insert_seconds);
      const std::vector<Index> changed = Pull(GoesByDegrees(mode, changes), changes);
      news = FindNews(graph_, changed);
      const Index bad_edge = QueueNews(news, disturbed, thresholds, &graph_);
      if (bad_edge != kNone) report.status = step_.NotFinite(bad_edge);
    }
    const UpdateTools<G> tools = {options_, graph_, step_, sizes_, sweep_};
    const double far_off = kShareOfFarOff * mean_.value() * graph_.hierarchy().level(0).num_edges;
    const bool may_rise = !changes.empty() || budget.IsToRest();
    const UpdatePlan plan = {budget, thresholds, news, far_off, may_rise};
    if (IsToBeOpened(mode, changes, plan)) {
      // Of an update it is a part of taking in what is new, which no limit of time cuts short.
      SolveOpened(tools, plan, mode == Mode::kFull ? budget.SecondsLeft() : kInfinity, &report);
    }
    // Where the work of an update is bounded by its amount.
    const bool in_slices = mode == Mode::kPartial && !budget.IsUncapped();
    if (in_slices) {
      newton_.DoSlice(tools, plan, &report);
    } else {
      newton_.Drop();
    }
    MergeDirty(tools, plan, &report);
    if (mode == Mode::kFull) {
      step.whole = SolveWholeGraph(tools, plan, &report);
    } else if (mode == Mode::kTop) {
      SolveTop(tools, plan, options_.window_iterations, &report);
    } else if (options_.schedule == Schedule::kStress) {
      const ScheduleResult windows = RunByDegrees(tools, plan, &report);
      report.at_rest = windows.at_rest;
      if (in_slices) newton_.Note(windows, plan.far_off, graph_);
    } else {
      RunFixedSchedule(tools, plan, changes.newest, &report);
    }
    report.newest_moved = MotionBetween(newest_before, PoseOf(changes.newest));
  }
  report.mean_chi2 = mean_.value();
  report.num_levels = graph_.hierarchy().num_levels();
  report.largest_moved = Larger(report.largest_moved, report.newest_moved);
  VLOG(1) << "update: " << report.new_nodes << " nodes, " << report.new_edges << " edges, "
          << report.windows << " windows, " << report.top_solves << " top solves, "
          << report.seconds * 1e3 << " ms";
  return step;
}

// Single closures, where most edges are in chains.
template <typename G>
bool Updater<G>::GoesByDegrees(Mode mode, const Changes& changes) const {
  return options_.schedule == Schedule::kStress && mode == Mode::kPartial && !IsMuch(changes) &&
         graph_.hierarchy().num_levels() > 1 && graph_.IsMostlyChains();
}

// What pulls otherwise from this update on: the changes, and what goes on to what it measures.
template <typename G>
std::vector<Index> Updater<G>::Pull(bool by_degrees, const Changes& changes) {
  std::vector<Index> edges = changes.edges;
  const auto add = [&](const std::vector<Index>& more) {
    edges.insert(edges.end(), more.begin(), more.end());
  };
  if (by_degrees) {
    add(far_closures_.GoOn(false, &graph_));
    add(far_closures_.Begin(changes.edges, options_.window_nodes, &graph_));
  } else {
    add(FarClosures<G>::EndAll(&graph_));
  }
  return edges;
}

template <typename G>
ScheduleResult Updater<G>::RunWindows(const UpdateTools<G>& tools, const UpdatePlan& plan,
                                      UpdateReport* report) {
  const int before = report->windows + report->top_solves;
  const ScheduleResult result = RunStressSchedule(tools, plan, report);
  far_closures_.NoteWindows(report->windows + report->top_solves - before);
  return result;
}

// While closures are under way an update solves its windows several times, as long as few edges in
// chains had to be looked at on the way, and no chain is to be cut first. The result is that of the
// last time.
template <typename G>
ScheduleResult Updater<G>::RunByDegrees(const UpdateTools<G>& tools, const UpdatePlan& plan,
                                        UpdateReport* report) {
  const double most = graph_.visited_edges() + kVisitedOfAWindow * options_.max_windows;
  ScheduleResult windows = RunWindows(tools, plan, report);
  for (int round = 1; round < kRoundsOfAnUpdate && !graph_.pulled().empty(); ++round) {
    if (graph_.visited_edges() > most || graph_.num_changes() > 0) break;
    const std::vector<Index> edges = far_closures_.GoOn(windows.at_rest, &graph_);
    QueueNews(NewsOf(graph_, edges), {}, plan.thresholds, &graph_);
    MergeDirty(tools, plan, report);
    windows = RunWindows(tools, plan, report);
  }
  windows.at_rest &= graph_.pulled().empty();
  return windows;
}

// The whole graph, again where chains could not follow, after they are cut. Cut short is what has
// left such chains as well.
template <typename G>
typename Updater<G>::Step Updater<G>::RunWhole(const Changes& changes, const Budget& budget,
                                               Gauge<G>* gauge) {
  Changes left = changes;
  Step sum;
  for (int round = 0; round < kFullTurns; ++round) {
    const Step step =
        Run(left, Mode::kFull, Budget(budget.Rest(), budget.IsToRest()), depth_, gauge);
    left = Changes::None(changes.newest);
    Accumulate(step.report, &sum.report);
    sum.whole = step.whole;
    if (!step.report.status.ok() || sum.whole == WholeSolve::kCutShort) return sum;
    if (graph_.num_changes() == 0) return sum;
    sum.whole = WholeSolve::kCutShort;
    if (budget.IsStopped()) return sum;
  }
  return sum;
}

// Beside what there is.
template <typename G>
bool Updater<G>::IsMuch(const Changes& changes) const {
  return graph_.num_edges() < kOpenedPerNew * changes.num_edges;
}

// Of much that is far off, bent chains, windows and rigid groups make knots.
template <typename G>
bool Updater<G>::IsToBeOpened(Mode mode, const Changes& changes, const UpdatePlan& plan) const {
  if (options_.schedule != Schedule::kStress || mode == Mode::kTop) return false;
  const Hierarchy<G>& hierarchy = graph_.hierarchy();
  if (mode == Mode::kFull) return IsFarOff(PendingEdges(plan.thresholds, hierarchy), hierarchy);
  return IsMuch(changes) && IsFarOff(plan.news.edges, hierarchy);
}

// Puts new nodes and edges in place, and holds what must be held.
template <typename G>
void Updater<G>::TakeIn(const Changes& changes, Gauge<G>* gauge, std::vector<Index>* disturbed) {
  gauge->AlignJoined(changes.edges, &graph_);
  graph_.Restructure();
  graph_.hierarchy().AssignGroups();
  const std::vector<Index> released = gauge->Hold(&graph_);
  disturbed->insert(disturbed->end(), released.begin(), released.end());
}

template <typename G>
StressThresholds Updater<G>::Thresholds(double depth) const {
  constexpr float kNever = std::numeric_limits<float>::infinity();
  const double mean = depth > 1 ? mean_at_depth_ : mean_.value();
  StressThresholds thresholds = StressThresholds::FromMean(mean, options_.stress_threshold / depth);
  if (options_.schedule != Schedule::kStress) thresholds.pending = kNever;  // nobody will look
  // Condensed edges hold measurements. Made anew whenever members move within their groups, they
  // would pull the groups back while the windows push the members on, without end.
  if (options_.coarse_edges == CoarseEdges::kCondensed) thresholds.dirty = kNever;
  return thresholds;
}

// Whether there is time for a solve of the whole graph. Not known before a window has been timed.
template <typename G>
bool Updater<G>::FitsWhole(const Changes& changes, const Budget& budget) const {
  if (budget.SecondsLeft() == kInfinity) return true;
  if (options_.schedule != Schedule::kStress) return true;  // their windows know no rest
  const Level<G>& level = graph_.hierarchy().level(0);
  const double seconds = sizes_.SecondsOf(
      sizes_.Worth(level.num_nodes + changes.num_nodes, level.num_edges + changes.num_edges), 0);
  return seconds > 0 && kIterationsToFit * seconds < budget.SecondsLeft();
}

template <typename G>
UpdateReport Updater<G>::Unchanged() const {
  UpdateReport report;
  report.num_levels = graph_.hierarchy().num_levels();
  report.mean_chi2 = mean_.value();
  report.at_rest = true;
  return report;
}

template <typename G>
UpdateReport Updater<G>::Converge(const Changes& changes, const UpdateLimits& limits,
                                  Gauge<G>* gauge) {
  UpdateReport sum = Unchanged();
  const bool has_changes = !changes.empty() || gauge->is_due();
  if (rest_ == Rest::kOptimum && !has_changes) return sum;
  const Budget budget(limits);
  const G newest_before = PoseOf(changes.newest);
  const Changes none = Changes::None(changes.newest);
  // Changes are taken in whatever the budget says.
  const bool at_once = FitsWhole(changes, budget);
  if (!at_once && has_changes) sum = Update(changes, Mode::kPartial, limits, gauge);
  sum.at_rest = false;  // that of an update is no optimum
  const bool goes_on = !has_changes || (sum.status.ok() && !budget.IsStopped());
  if (at_once || (goes_on && FitsWhole(none, budget))) {
    ResetDepth();
    const Step full = RunWhole(at_once ? changes : none, budget, gauge);
    Accumulate(full.report, &sum);
    sum.at_rest = full.whole != WholeSolve::kCutShort && full.report.status.ok();
    rest_ = sum.at_rest ? Rest::kOptimum : Rest::kNot;
    if (!full.report.status.ok()) {  // the rest is done
      Accumulate(Update(none, Mode::kPartial, budget.Rest(), gauge), &sum);
      sum.status = full.report.status;
      sum.at_rest = false;
    }
  } else if (goes_on) {
    const UpdateReport refined = Refine(none, budget.Rest(), gauge);
    Accumulate(refined, &sum);
    sum.at_rest = refined.at_rest;
  }
  sum.newest_moved = MotionBetween(newest_before, PoseOf(changes.newest));
  sum.seconds = budget.SecondsSpent();
  return sum;
}

template double CostOf(CondensedGraph<SE2>*);
template double CostOf(CondensedGraph<SE3>*);
template double CostOf(CondensedGraph<YawPose>*);
template class Updater<SE2>;
template class Updater<SE3>;
template class Updater<YawPose>;

}  // namespace hpgo
