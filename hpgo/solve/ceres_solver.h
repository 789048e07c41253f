// The reference engine: a ceres::Problem for each Subproblem.
#pragma once

#include <memory>

#include "hpgo/solve/subproblem.h"

namespace hpgo {

// Levenberg-Marquardt with SPARSE_NORMAL_CHOLESKY on SuiteSparse, one thread. The cost objects are
// made once and given new measurements in each Solve, which reports
//   kInvalidArgument where a term's information is not positive semi-definite or a custom cost is
//     not over poses; the poses are unchanged,
//   kNoSolution where Ceres finds no usable solution; the poses are unchanged.
template <typename G>
std::unique_ptr<SubproblemSolver<G>> MakeCeresSolver();

}  // namespace hpgo
