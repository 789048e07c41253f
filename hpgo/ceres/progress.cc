#include "hpgo/ceres/progress.h"

#include <cstdarg>
#include <cstdio>

#include "glog/logging.h"

namespace hpgo {

std::string Format(const char* format, ...) {
  char text[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

void PrintProgress(const ceres::Solver::Options& options,
                   const ceres::IterationSummary& iteration) {
  if (options.logging_type == ceres::SILENT) return;
  if (!options.minimizer_progress_to_stdout && !VLOG_IS_ON(1)) return;
  std::string line;
  if (iteration.iteration == 0) {
    line =
        "iter      cost      cost_change  |gradient|   |step|    tr_ratio  tr_radius  ls_iter  "
        "iter_time  total_time\n";
  }
  line += Format("% 4d % 8e   % 3.2e   % 3.2e  % 3.2e  % 3.2e % 3.2e     % 4d   % 3.2e   % 3.2e",
                 iteration.iteration, iteration.cost, iteration.cost_change,
                 iteration.gradient_max_norm, iteration.step_norm, iteration.relative_decrease,
                 iteration.trust_region_radius, iteration.linear_solver_iterations,
                 iteration.iteration_time_in_seconds, iteration.cumulative_time_in_seconds);
  if (options.minimizer_progress_to_stdout) {
    std::printf("%s\n", line.c_str());
  } else {
    VLOG(1) << line;
  }
}

}  // namespace hpgo
