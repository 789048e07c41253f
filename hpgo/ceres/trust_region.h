// Minimizes a PoseSystem as ceres::Solve would, by its options and into its summary.
#pragma once

#include "ceres/solver.h"
#include "hpgo/ceres/pose_system.h"

namespace hpgo {

// Gauss-Newton steps, shortened and damped where they do not lower the cost, and corrected by what
// the last ones were short of (SecantPairs). Honours the limits,
// tolerances, callbacks, progress output and update_state_every_iteration of the options. Fills
// what a minimizer does of the summary: termination, message, costs, iterations, their counts and
// times. False, with nothing written, called or printed, if the costs cannot be evaluated at the
// start.
[[nodiscard]] bool MinimizeAsCeres(const ceres::Solver::Options& options, PoseSystem* system,
                                   ceres::Solver::Summary* summary);

}  // namespace hpgo
