// Updater: idle work.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hpgo/update/constants.h"
#include "hpgo/update/motion.h"
#include "hpgo/update/updater.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

// What is disturbed is refined from the start.
template <typename G>
void Updater<G>::ResetDepth() {
  depth_ = 1;
  solved_at_depth_ = 0;
  mean_at_depth_ = kInfinity;
}

template <typename G>
UpdateReport Updater<G>::Refine(const Changes& changes, const UpdateLimits& limits,
                                Gauge<G>* gauge) {
  const bool has_changes = !changes.empty() || gauge->is_due();
  // The other schedules put windows wherever they do: they know no rest to work towards.
  if (options_.schedule != Schedule::kStress) {
    rest_ = Rest::kNot;
    return Run(changes, Mode::kPartial, Budget(limits), depth_, gauge).report;
  }
  if (rest_ != Rest::kNot && !has_changes) return Unchanged();
  rest_ = Rest::kNot;
  const Budget budget(limits, true);
  const G newest_before = PoseOf(changes.newest);
  if (has_changes) ResetDepth();
  double cost = kInfinity;
  Changes left = changes;
  UpdateReport sum;
  do {
    if (solved_at_depth_ > kMostPasses * graph_.hierarchy().level(0).num_nodes) {
      // Windows that undo each other's work, or that are small beside what they belong to.
      const Step full = RunWhole(left, budget, gauge);
      const bool ended = full.whole != WholeSolve::kCutShort;
      if (ended) solved_at_depth_ = 0;
      Accumulate(full.report, &sum);
      sum.at_rest = full.report.status.ok() && ended;
      break;
    }
    const UpdateReport report =
        Run(left, Mode::kPartial, Budget(budget.Rest(), true), depth_, gauge).report;
    left = Changes::None(changes.newest);
    Accumulate(report, &sum);
    if (!report.status.ok()) break;
    solved_at_depth_ += report.solved_nodes;
    sum.at_rest = report.at_rest;
    if (!sum.at_rest) continue;
    solved_at_depth_ = 0;
    // Over all edges, those in chains among them: a sample's mean may be far above what is left.
    cost = CostOf(&graph_);
    const bool is_known = graph_.num_edges() > 0 && std::isfinite(cost);
    const double mean = is_known ? cost / graph_.num_edges() : mean_.value();
    const bool gaining = std::exchange(mean_at_depth_, mean) - mean > kGainToGoDeeper * mean;
    if (depth_ >= kDeep && !gaining) continue;
    depth_ *= kDeeper;
    graph_.SettleAll();
    QueueAll(Thresholds(depth_), &graph_.hierarchy());
    sum.at_rest = false;
  } while (!sum.at_rest && !budget.IsStopped());
  // Updates take it of the edges of level 0, where a chain is one.
  const int num_edges = graph_.hierarchy().level(0).num_edges;
  if (sum.at_rest && num_edges > 0 && std::isfinite(cost)) mean_.Set(cost / num_edges);
  if (sum.at_rest) rest_ = Rest::kRefined;
  sum.newest_moved = MotionBetween(newest_before, PoseOf(changes.newest));
  sum.largest_moved = Larger(sum.largest_moved, sum.newest_moved);
  sum.seconds = budget.SecondsSpent();
  return sum;
}

template class Updater<SE2>;
template class Updater<SE3>;
template class Updater<YawPose>;

}  // namespace hpgo
