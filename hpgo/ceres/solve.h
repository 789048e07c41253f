// ceres::Solve for pose graphs: the same call, the same problem, several times as fast.
#pragma once

#include "ceres/problem.h"
#include "ceres/solver.h"
#include "hpgo/ceres/pose_layout.h"

namespace hpgo {

// Minimizes the problem's own objective in place, from the values its blocks hold, by Gauss-Newton
// on the blocks of the Hessian (hpgo/solve/block_cholesky.h).
//
//   hpgo::Solve(options, &problem, &summary);  // was: ceres::Solve
//
// Taken is a problem in which every residual is over one or two poses, each stored in parameter
// blocks as PoseLayout::sizes lists; which blocks are one pose is found by looking, or declared.
// Any cost functions (automatic, analytic, with Jacobians made for their manifold alone), losses,
// manifolds; priors on poses or parts of them; poses constant in whole or in part; further constant
// blocks in a cost. What the numbers of a pose mean need not be known: see PoseSystem.
//
// Any other problem goes to ceres::Solve with the same options, as do options for what is not done
// here (line search, inner iterations, gradient checks, dumps), options that are not valid, and
// problems that cannot be evaluated where they stand. Then summary->message begins with "hpgo: left
// to ceres::Solve: " and the reason.
//
// Of the options count the limits on iterations and time, the three tolerances, callbacks,
// minimizer_progress_to_stdout, logging_type, update_state_every_iteration and
// max_trust_region_radius; those that choose Ceres' linear solvers and trust region do not. One
// thread, whatever num_threads says. The summary is filled as Ceres does. An EvaluationCallback of
// the problem is not called: Ceres 2.1 does not show it.
//
// Blocks that are constant, or that no residual uses, keep their bits. On USER_FAILURE, and where
// ceres::Solve fails, all do. A problem is used by one thread at a time.
void Solve(const ceres::Solver::Options& options, ceres::Problem* problem,
           ceres::Solver::Summary* summary);

// With a declared layout; only its sizes matter here.
void Solve(const ceres::Solver::Options& options, ceres::Problem* problem,
           ceres::Solver::Summary* summary, const PoseLayout& layout);

}  // namespace hpgo
