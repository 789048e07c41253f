// What a solve says on its way and at its end.
#pragma once

#include <string>

#include "ceres/iteration_callback.h"
#include "ceres/solver.h"

namespace hpgo {

[[gnu::format(printf, 1, 2)]] std::string Format(const char* format, ...);

// The line of Ceres for an iteration, to where the options want it; before the first the headings.
void PrintProgress(const ceres::Solver::Options& options, const ceres::IterationSummary& iteration);

}  // namespace hpgo
