// Uncertainty of single poses.
#pragma once

#include "hpgo/graph/status.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// The covariance of the free pose `index`, under a right perturbation, with all other free poses
// marginalized and the constant ones known: a block of the inverse of the Hessian at the current
// poses. Factors the whole problem. kNoSolution where the Hessian is singular.
template <typename G>
Result<typename G::Matrix> MarginalCovariance(const Subproblem<G>& problem, int index);

}  // namespace hpgo
