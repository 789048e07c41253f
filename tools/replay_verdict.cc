#include "tools/replay_verdict.h"

#include <cmath>

#include "tools/command.h"
#include "tools/console.h"
#include "tools/replay_flags.h"

namespace hpgo_cli {
namespace {

// True if a gap is above the threshold or could not be found.
bool MissesThreshold(const ReplayResult& result) {
  if (!(FLAGS_compare_threshold >= 0)) return false;
  bool misses = !result.comparison_failure.ok();
  const auto check = [&misses](const FullComparison& comparison) {
    if (comparison.gap_percent <= FLAGS_compare_threshold) return;
    misses = true;
    Error("the gap at " + FormatAs("%.4g", comparison.percent) + " %, " +
          FormatAs("%.4g", comparison.gap_percent) + " %, is above " +
          FormatAs("%g", FLAGS_compare_threshold) + " %");
  };
  for (const FullComparison& comparison : result.comparisons) check(comparison);
  for (const FullComparison& comparison : result.closures.comparisons) check(comparison);
  if (result.refine.has_value() && result.refine->after.has_value()) check(*result.refine->after);
  return misses;
}

}  // namespace

int JudgeReplay(const ReplayFigures& figures) {
  const ReplayResult& result = figures.result;
  if (result.failed_updates > 0) {
    Warn(Plural(result.failed_updates, "update") +
         " failed and changed nothing; the first: " + result.first_failure.message());
  }
  if (!result.comparison_failure.ok()) {
    Warn("no full optimum to compare with: " + result.comparison_failure.message());
  }
  if (!figures.recovery_failure.ok()) {
    Warn("the far-off closure failed: " + figures.recovery_failure.message());
  }
  if (result.refine.has_value() && !(result.refine->cost_after <= result.refine->cost_before)) {
    Warn("refining raised the cost from " + FormatNumber(result.refine->cost_before) + " to " +
         FormatNumber(result.refine->cost_after));
  }
  if (!std::isfinite(figures.cost)) {
    Error("the cost of the estimate is not a number");
    return kExitNoSolution;
  }
  if (result.interrupted) {
    Warn("interrupted after " + Plural(result.steps, "node") + "; the result is of those");
    return kExitInterrupted;
  }
  if (MissesThreshold(result)) return kExitComparison;
  return result.failed_updates > 0 || !figures.recovery_failure.ok() ? kExitLimit : kExitOk;
}

}  // namespace hpgo_cli
