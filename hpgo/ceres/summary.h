// The parts of a ceres::Solver::Summary that tell of the problem and the solver.
#pragma once

#include "ceres/solver.h"
#include "hpgo/ceres/pose_system.h"
#include "hpgo/ceres/problem_view.h"

namespace hpgo {

// Fills all but the termination, costs, iterations and times.
void DescribeProblem(const ceres::Solver::Options& options, const ProblemView& problem,
                     const PoseSystem& system, ceres::Solver::Summary* summary);

}  // namespace hpgo
