// Optimizer: idle work.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hpgo/optimizer_impl.h"

namespace hpgo {
// Adds the counts and times of one step; status, levels and means are the latest.
void Accumulate(const UpdateReport& step, UpdateReport* sum) {
  sum->status = step.status;
  sum->num_levels = step.num_levels;
  sum->mean_chi2 = step.mean_chi2;
  sum->new_nodes += step.new_nodes;
  sum->new_edges += step.new_edges;
  sum->merged_edges += step.merged_edges;
  sum->examined_edges += step.examined_edges;
  sum->windows += step.windows;
  sum->largest_moved.distance = std::max(sum->largest_moved.distance, step.largest_moved.distance);
  sum->largest_moved.angle = std::max(sum->largest_moved.angle, step.largest_moved.angle);
  sum->top_solves += step.top_solves;
  sum->solved_nodes += step.solved_nodes;
  sum->cost_decrease += step.cost_decrease;
  sum->insert_seconds += step.insert_seconds;
  sum->merge_seconds += step.merge_seconds;
  sum->examine_seconds += step.examine_seconds;
  sum->top_seconds += step.top_seconds;
  sum->window_seconds += step.window_seconds;
}

// The mean over all edges, those in chains among them.
template <typename G>
void Optimizer<G>::Impl::MeasureChi2() {
  const Index num_edges = graph_.num_edges();
  const double cost = Cost();
  if (num_edges > 0 && std::isfinite(cost)) mean_chi2_ = cost / num_edges;
}

// Puts every edge up for examination.
template <typename G>
void Optimizer<G>::Impl::QueueAll() {
  for (int l = 0; l < hierarchy_.num_levels(); ++l) {
    const Level<G>& level = hierarchy_.level(l);
    for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
      if (!level.edges[e].alive) continue;
      hierarchy_.SetPending(l, e, std::max(level.edges[e].pending, 2 * thresholds_.pending),
                            thresholds_.pending);
    }
  }
}

template <typename G>
UpdateReport Optimizer<G>::Impl::Refine(const UpdateLimits& limits) {
  at_optimum_ = false;
  // Beyond rest at the threshold of updates: everything is examined again at smaller ones.
  constexpr double kDeep = 100, kDeepest = 1e6, kDeeper = 10;
  // Ill-conditioned graphs go on gaining: then below kDeep as well, while a round gains this share.
  constexpr double kWorthwhile = 1e-5;
  // Where the levels' models disagree, windows may undo each other's work for ever. So the cost is
  // looked at after the work of so many passes over the graph, and whenever that has doubled.
  constexpr double kPasses = 50, kStandstill = 1e-6;  // the latter of the cost
  // No more than about 50,000 passes: where all is ill-conditioned the cost may creep for ever.
  constexpr int kMostLooks = 10;
  int looks = 0;
  const double first_look = kPasses * hierarchy_.level(0).num_nodes;
  double work = 0, next_look = first_look;
  double cost_at_look = std::numeric_limits<double>::infinity();
  const auto stands_still = [&] {
    if (work < next_look) return false;
    next_look = 2 * work;
    ++looks;
    const double before = std::exchange(cost_at_look, Cost());
    // A window promised more than tau; or the cost is infinite.
    return !(before - cost_at_look >= std::max(kStandstill * cost_at_look, thresholds_.tau));
  };
  double last_mean = std::numeric_limits<double>::infinity();
  const Clock::time_point start = Clock::now();
  const double cpu_start = ThreadCpuSeconds();
  const auto elapsed = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const auto stopped = [&] {
    return (limits.max_seconds > 0 && elapsed() > limits.max_seconds) ||
           (limits.max_cpu_seconds > 0 &&
            ThreadCpuSeconds() - cpu_start > limits.max_cpu_seconds) ||
           (limits.cancel != nullptr && *limits.cancel);
  };
  UpdateReport sum;
  if (options_.schedule != Schedule::kStress) {
    // Windows wherever the schedule puts them: it knows no rest to work towards.
    return Step(Mode::kPartial, limits);
  }
  const G newest_before = NewestPose();
  if (!new_nodes_.empty() || !new_edges_.empty() || check_anchors_) depth_ = 1;
  do {
    const UpdateLimits left = Remaining(limits, elapsed(), ThreadCpuSeconds() - cpu_start);
    refining_ = true;
    const UpdateReport step = Step(Mode::kPartial, left);
    refining_ = false;
    Accumulate(step, &sum);
    if (!step.status.ok()) break;
    work += step.solved_nodes;
    sum.at_rest = step.at_rest || stands_still();
    if (sum.at_rest) {
      // A sample's mean may be far above what is left.
      const double tau = thresholds_.tau;
      MeasureChi2();
      const bool gaining = last_mean - mean_chi2_ > kWorthwhile * mean_chi2_;
      last_mean = mean_chi2_;
      const bool deeper = depth_ < kDeep || (gaining && depth_ < kDeepest);
      if (deeper) depth_ *= kDeeper;
      SetThresholds();
      if (deeper || thresholds_.tau < 0.5 * tau) {
        graph_.SettleAll();
        QueueAll();
        work = 0;
        next_look = first_look;
        looks = 0;
        sum.at_rest = false;
      }
    }
  } while (!sum.at_rest && looks < kMostLooks && !stopped());
  sum.newest_moved = MotionBetween(newest_before, NewestPose());
  sum.largest_moved.distance = std::max(sum.largest_moved.distance, sum.newest_moved.distance);
  sum.largest_moved.angle = std::max(sum.largest_moved.angle, sum.newest_moved.angle);
  sum.seconds = elapsed();
  return sum;
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
