#include "hpgo/update/budget.h"

#include <time.h>

#include <algorithm>
#include <chrono>
#include <limits>

#include "hpgo/update/constants.h"

namespace hpgo {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double WallSeconds() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

double ThreadCpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

Clocks Clocks::Real() { return {WallSeconds, ThreadCpuSeconds}; }

Stopwatch::Stopwatch(double* total) : total_(total), start_(WallSeconds()) {}
double Stopwatch::Elapsed() const { return WallSeconds() - start_; }

Budget::Budget(const UpdateLimits& limits, bool to_rest, const Clocks& clocks)
    : limits_(limits),
      to_rest_(to_rest),
      clocks_(clocks),
      wall_start_(clocks.wall()),
      cpu_start_(limits.max_cpu_seconds > 0 ? clocks.cpu() : 0) {}

double Budget::SecondsLeft() const {
  double left = kInfinity;
  if (limits_.max_seconds > 0) left = limits_.max_seconds - SecondsSpent();
  if (limits_.max_cpu_seconds > 0) {
    left = std::min(left, limits_.max_cpu_seconds - (clocks_.cpu() - cpu_start_));
  }
  return left;
}

double Budget::SecondsForWindow() const {
  double limit = kInfinity;
  if (limits_.max_seconds > 0) limit = limits_.max_seconds;
  if (limits_.max_cpu_seconds > 0) limit = std::min(limit, limits_.max_cpu_seconds);
  return std::min(kWindowShareOfTime * limit, SecondsLeft());
}

UpdateLimits Budget::Rest() const {
  constexpr double kShortest = 1e-9;  // 0 would be no limit
  UpdateLimits rest = limits_;
  if (rest.max_seconds > 0) {
    rest.max_seconds = std::max(rest.max_seconds - SecondsSpent(), kShortest);
  }
  if (rest.max_cpu_seconds > 0) {
    rest.max_cpu_seconds = std::max(rest.max_cpu_seconds - (clocks_.cpu() - cpu_start_), kShortest);
  }
  return rest;
}

}  // namespace hpgo
