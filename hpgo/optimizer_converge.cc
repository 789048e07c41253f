// Optimizer: to the optimum in one call.

#include <time.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hpgo/optimizer_impl.h"

namespace hpgo {

double ThreadCpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

UpdateLimits Remaining(const UpdateLimits& limits, double seconds, double cpu_seconds) {
  constexpr double kShortest = 1e-9;  // 0 would be no limit
  UpdateLimits left = limits;
  if (limits.max_seconds > 0) left.max_seconds = std::max(limits.max_seconds - seconds, kShortest);
  if (limits.max_cpu_seconds > 0) {
    left.max_cpu_seconds = std::max(limits.max_cpu_seconds - cpu_seconds, kShortest);
  }
  return left;
}

template <typename G>
double Optimizer<G>::Impl::TimeLimit() const {
  double limit = std::numeric_limits<double>::infinity();
  if (limits_.max_seconds > 0) limit = limits_.max_seconds;
  if (limits_.max_cpu_seconds > 0) limit = std::min(limit, limits_.max_cpu_seconds);
  return limit;
}

template <typename G>
UpdateReport Optimizer<G>::Impl::Converge(const UpdateLimits& limits) {
  constexpr int kIterations = 3;       // of a whole solve that has to fit: fewer leave a gap
  constexpr double kFillGrowth = 1.3;  // of the time of a solve with its size
  UpdateReport sum;
  sum.num_levels = hierarchy_.num_levels();
  sum.mean_chi2 = mean_chi2_;
  if (at_optimum_ && new_nodes_.empty() && new_edges_.empty() && !check_anchors_) {
    sum.at_rest = true;
    return sum;
  }
  const Clock::time_point start = Clock::now();
  const double cpu_start = ThreadCpuSeconds();
  const G newest_before = NewestPose();
  const auto left = [&] {
    return Remaining(limits, Seconds(Clock::now() - start), ThreadCpuSeconds() - cpu_start);
  };
  depth_ = 1;
  at_optimum_ = false;
  // Far-off parts are brought near first, where a solve of everything converges best.
  UpdateReport step = Step(Mode::kPartial, left());
  Accumulate(step, &sum);
  limits_ = left();
  started_ = Clock::now();
  cpu_started_ = ThreadCpuSeconds();
  const bool stopped = IsStopped();
  const Level<G>& level = hierarchy_.level(0);
  const double worth = std::max(static_cast<double>(level.num_nodes) / options_.window_nodes,
                                static_cast<double>(level.num_edges) / options_.window_edges);
  const double whole = UsualWindowSeconds(0) * std::pow(worth, kFillGrowth);
  const bool fits = kIterations * whole < SecondsLeft();
  limits_ = UpdateLimits();
  if (step.status.ok() && !stopped) {
    converged_ = true;  // where nothing is free
    step = fits ? Step(Mode::kFull, left()) : Refine(left());
    Accumulate(step, &sum);
    sum.at_rest = fits && converged_ && step.status.ok();
    at_optimum_ = sum.at_rest;
  }
  sum.newest_moved = MotionBetween(newest_before, NewestPose());
  sum.seconds = Seconds(Clock::now() - start);
  return sum;
}

template <typename G>
UpdateReport Optimizer<G>::Converge(const UpdateLimits& limits) {
  return impl_->Converge(limits);
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;
template class Optimizer<SE2>;
template class Optimizer<SE3>;

}  // namespace hpgo
