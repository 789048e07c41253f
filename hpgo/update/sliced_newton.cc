#include "hpgo/update/sliced_newton.h"

#include "glog/logging.h"
#include "hpgo/update/constants.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
void SlicedNewton<G>::DoSlice(const UpdateTools<G>& tools, const UpdatePlan& plan,
                              UpdateReport* report) {
  const Stopwatch watch(&report->window_seconds);
  switch (stage_) {
    case Stage::kIdle:
      return;
    case Stage::kWanted:
      stage_ = Begin(tools);
      break;
    case Stage::kFactoring:
      stage_ = Factor();
      break;
    case Stage::kStepping:
      stage_ = Step(tools, plan, report);
      break;
  }
  if (stage_ == Stage::kIdle) Drop();
}

template <typename G>
void SlicedNewton<G>::Note(const ScheduleResult& windows, double cost,
                           const Hierarchy<G>& hierarchy) {
  if (windows.at_rest) return Drop();
  const Level<G>& level = hierarchy.level(0);
  const bool is_useful = hierarchy.num_levels() > 1 && level.num_nodes <= kMostNodesOfNewton;
  const bool is_far_off = is_useful && windows.decrease > kShareOfFarOff * cost;
  updates_far_off_ = is_far_off ? updates_far_off_ + 1 : 0;
  if (stage_ == Stage::kIdle && updates_far_off_ == kUpdatesFarOff) stage_ = Stage::kWanted;
}

template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Begin(const UpdateTools<G>& tools) {
  Window<G>& window = tools.step.window();
  if (!window.BuildWhole(0, &tools.graph.hierarchy(), false)) return Stage::kIdle;
  VLOG(1) << "newton: factors " << window.num_free() << " nodes";
  return newton_.Begin(&window.subproblem(), window.nodes()) ? Stage::kFactoring : Stage::kIdle;
}

template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Factor() {
  using Progress = typename SimplifiedNewton<G>::Progress;
  ++slices_;
  switch (newton_.GoOn(kMultiplicationsOfASlice)) {
    case Progress::kUnderWay:
      return Stage::kFactoring;
    case Progress::kDone:
      return Stage::kStepping;
    case Progress::kFailed:
      break;
  }
  return Stage::kIdle;
}

template <typename G>
typename SlicedNewton<G>::Stage SlicedNewton<G>::Step(const UpdateTools<G>& tools,
                                                      const UpdatePlan& plan,
                                                      UpdateReport* report) {
  Window<G>& window = tools.step.window();
  if (!window.BuildWhole(0, &tools.graph.hierarchy(), false)) return Stage::kIdle;
  ++report->windows;
  newton_.SetNames(&window.nodes());
  const double cost = window.Cost();
  StressThresholds thresholds = plan.thresholds;
  // All of it moves: what is a little stale everywhere adds up, and windows above would undo the
  // step by it.
  if (tools.options.coarse_edges == CoarseEdges::kGalerkin) thresholds.dirty = 0;
  const StepResult step = tools.step.SolveBy(&newton_, {}, thresholds, plan.budget);
  hpgo::Note(step, report);
  VLOG(1) << "newton: cost " << cost << " -> " << cost - step.decrease;
  return step.decrease > kShareOfFarOff * cost ? Stage::kStepping : Stage::kIdle;
}

// To where it was when it was saved.
template <typename G>
void SlicedNewton<G>::FactorAgain() {
  for (int k = 0; k < slices_; ++k) newton_.GoOn(kMultiplicationsOfASlice);
}

template class SlicedNewton<SE2>;
template class SlicedNewton<SE3>;
template class SlicedNewton<YawPose>;

}  // namespace hpgo
