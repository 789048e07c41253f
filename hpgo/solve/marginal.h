// Uncertainty of single poses.
#pragma once

#include <vector>

#include "Eigen/Core"
#include "hpgo/graph/status.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// The covariance of the free pose `index`, under a right perturbation, with all other free poses
// marginalized and the constant ones known: a block of the inverse of the Hessian at the current
// poses. Factors the whole problem. kNoSolution where the pose is not determined.
//
// Directions that nothing measures do no harm where `index` is not affected.
template <typename G>
Result<typename G::Matrix> MarginalCovariance(const Subproblem<G>& problem, int index);

// The joint covariance of free poses, in the order of `indices`, which are distinct.
template <typename G>
Result<Eigen::MatrixXd> JointCovariance(const Subproblem<G>& problem,
                                        const std::vector<int>& indices);

}  // namespace hpgo
