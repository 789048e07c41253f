#include "hpgo/update/sliced_newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "glog/logging.h"
#include "hpgo/update/constants.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
void SlicedNewton<G>::DoSlice(const UpdateTools<G>& tools, const UpdatePlan& plan,
                              UpdateReport* report) {
  if (plan.budget.IsCancelled()) return;
  const Stopwatch watch(&report->window_seconds);
  if (std::exchange(is_loaded_, false)) stage_ = Resume();
  switch (stage_) {
    case Stage::kIdle:
    case Stage::kSpent:
      return;
    case Stage::kWanted:
      stage_ = Begin(tools);
      break;
    case Stage::kFactoring:
      stage_ = Factor();
      break;
    case Stage::kFactored:
    case Stage::kStepping:
      stage_ = Step(tools, plan, report);
      break;
  }
  if (stage_ == Stage::kIdle) Drop();
}

template <typename G>
void SlicedNewton<G>::Note(const ScheduleResult& windows, double far_off,
                           const CondensedGraph<G>& graph) {
  if (windows.at_rest) return Drop();
  const Hierarchy<G>& hierarchy = graph.hierarchy();
  const Level<G>& level = hierarchy.level(0);
  // The top is solved whole as it is; chains that hold most of the edges do not follow such a step.
  const bool can_gain = hierarchy.num_levels() > 1 && !graph.IsMostlyChains();
  // Few nodes of a large map cannot gain as much.
  const double share = static_cast<double>(windows.solved_nodes) / level.num_nodes;
  const bool is_far_off = can_gain && windows.decrease > far_off * std::sqrt(std::min(1., share));
  updates_far_off_ = is_far_off ? updates_far_off_ + 1 : 0;
  if (stage_ == Stage::kSpent && !is_far_off) return Drop();
  const bool begins = stage_ == Stage::kIdle && updates_far_off_ == kUpdatesFarOff;
  if (begins || stage_ == Stage::kSpent) stage_ = Stage::kWanted;
}

// As a window; false if it is too large, or nothing is free.
template <typename G>
bool SlicedNewton<G>::BuildLevel(const UpdateTools<G>& tools) {
  Hierarchy<G>& hierarchy = tools.graph.hierarchy();
  return hierarchy.level(0).num_nodes <= kMostNodesOfNewton &&
         tools.step.window().BuildWhole(0, &hierarchy, false);
}

template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Begin(const UpdateTools<G>& tools) {
  if (!BuildLevel(tools)) return Stage::kIdle;
  Window<G>& window = tools.step.window();
  VLOG(1) << "newton: factors " << window.num_free() << " nodes";
  if (!newton_.Begin(window.subproblem(), window.nodes())) return Stage::kIdle;
  if (newton_.factor_size() > kMostNumbersOfNewton) return Stage::kIdle;
  slices_ = 0;
  const Level<G>& level = tools.graph.hierarchy().level(0);
  known_.assign(level.edges.size(), 0);
  for (const Index e : window.edges()) known_[e] = level.edges[e].generation + 1;
  return Stage::kFactoring;
}

template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Factor() {
  using Progress = typename SimplifiedNewton<G>::Progress;
  ++slices_;
  switch (newton_.GoOn(kMultiplicationsOfASlice)) {
    case Progress::kUnderWay:
      return Stage::kFactoring;
    case Progress::kDone:
      return Stage::kFactored;
    case Progress::kFailed:
      break;
  }
  return Stage::kIdle;
}

template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Step(const UpdateTools<G>& tools,
                                                      const UpdatePlan& plan,
                                                      UpdateReport* report) {
  if (!BuildLevel(tools)) return Stage::kIdle;
  ++report->windows;
  newton_.SetNames(&tools.step.window().nodes());
  const Level<G>& level = tools.graph.hierarchy().level(0);
  const StressThresholds thresholds = plan.thresholds.MergingAll(tools.options.coarse_edges);
  const StepResult step = tools.step.SolveBy(&newton_, {}, thresholds, plan.budget, [&](Index e) {
    return e < static_cast<Index>(known_.size()) && known_[e] == level.edges[e].generation + 1;
  });
  hpgo::Note(step, report);
  VLOG(1) << "newton: cost " << step.initial_cost << " -> " << step.initial_cost - step.decrease;
  if (step.decrease > kShareOfFarOff * step.initial_cost) return Stage::kStepping;
  return stage_ == Stage::kStepping ? Stage::kSpent : Stage::kIdle;
}

// To where it was when it was saved; idle if what was loaded makes no sense.
template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Resume() {
  using Progress = typename SimplifiedNewton<G>::Progress;
  if (!newton_.Resume()) return Stage::kIdle;
  Progress progress = Progress::kUnderWay;
  // Another machine may order it in another way.
  const auto goes_on = [&](int k) { return k < slices_ || stage_ > Stage::kFactoring; };
  for (int k = 0; goes_on(k) && progress == Progress::kUnderWay; ++k) {
    progress = newton_.GoOn(kMultiplicationsOfASlice);
  }
  return progress == Progress::kFailed ? Stage::kIdle : stage_;
}

template class SlicedNewton<SE2>;
template class SlicedNewton<SE3>;
template class SlicedNewton<YawPose>;

}  // namespace hpgo
