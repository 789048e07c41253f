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

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Whether work goes on without getting anywhere.
class Standstill {
 public:
  explicit Standstill(double first_look) : next_look_(first_look) {}
  // After so much more work, in nodes solved.
  template <typename Cost>
  bool IsReached(double work, double tau, const Cost& cost) {
    work_ += work;
    if (work_ < next_look_) return false;
    next_look_ = 2 * work_;
    ++looks_;
    const double before = std::exchange(cost_, cost());
    // A window promised more than tau; or the cost is infinite.
    return !(before - cost_ >= std::max(kStandstill * cost_, tau));
  }
  bool HasLookedEnough() const { return looks_ >= kMostLooks; }

 private:
  double work_ = 0, next_look_;
  double cost_ = kInfinity;  // at the last look
  int looks_ = 0;
};

}  // namespace

template <typename G>
UpdateReport Updater<G>::Refine(const Changes& changes, const UpdateLimits& limits,
                                Gauge<G>* gauge) {
  at_optimum_ = false;
  // The other schedules put windows wherever they do: they know no rest to work towards.
  if (options_.schedule != Schedule::kStress) {
    return Run(changes, Mode::kPartial, Budget(limits), depth_, gauge).report;
  }
  const Budget budget(limits, true);
  const G newest_before = PoseOf(changes.newest);
  if (!changes.empty() || gauge->is_due()) depth_ = 1;
  const double first_look = kPassesToFirstLook * graph_.hierarchy().level(0).num_nodes;
  Standstill standstill(first_look);
  double last_mean = kInfinity;
  Changes left = changes;
  UpdateReport sum;
  do {
    const UpdateReport report =
        Run(left, Mode::kPartial, Budget(budget.Rest(), true), depth_, gauge).report;
    left = Changes();
    left.newest = changes.newest;
    Accumulate(report, &sum);
    if (!report.status.ok()) break;
    const double tau = Thresholds(depth_).tau;
    sum.at_rest = report.at_rest ||
                  standstill.IsReached(report.solved_nodes, tau, [&] { return CostOf(&graph_); });
    if (!sum.at_rest) continue;
    // Over all edges, those in chains among them: a sample's mean may be far above what is left.
    const double cost = CostOf(&graph_);
    if (graph_.num_edges() > 0 && std::isfinite(cost)) mean_.Set(cost / graph_.num_edges());
    const bool gaining = last_mean - mean_.value() > kGainToGoDeeper * mean_.value();
    last_mean = mean_.value();
    const bool deeper = depth_ < kDeep || (gaining && depth_ < kDeepest);
    if (deeper) depth_ *= kDeeper;
    const StressThresholds thresholds = Thresholds(depth_);
    if (!deeper && !(thresholds.tau < 0.5 * tau)) continue;
    graph_.SettleAll();
    QueueAll(thresholds, &graph_.hierarchy());
    standstill = Standstill(first_look);
    sum.at_rest = false;
  } while (!sum.at_rest && !standstill.HasLookedEnough() && !budget.IsStopped());
  sum.newest_moved = MotionBetween(newest_before, PoseOf(changes.newest));
  sum.largest_moved = Larger(sum.largest_moved, sum.newest_moved);
  sum.seconds = budget.SecondsSpent();
  return sum;
}

template class Updater<SE2>;
template class Updater<SE3>;

}  // namespace hpgo
