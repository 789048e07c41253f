// What the tests of the block engine share: an engine, and Ceres to compare it with.
#pragma once

#include <memory>

#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "hpgo/solve/ceres_solver.h"
#include "small_problems.h"

namespace hpgo {

inline SubproblemOptions ToConvergence() {
  SubproblemOptions options;
  options.max_iterations = 300;
  options.function_tolerance = 1e-13;
  return options;
}

template <typename G>
class BlockSolverFixture : public testing::Test {
 protected:
  // Both engines from the same poses; leaves those of the block engine.
  void ExpectEqualToCeres(Subproblem<G>* problem, double pose_tolerance) {
    Subproblem<G> by_ceres = *problem;
    const SubproblemSummary expected = ceres_->Solve(ToConvergence(), &by_ceres);
    const SubproblemSummary actual = solver_->Solve(ToConvergence(), problem);
    ASSERT_TRUE(expected.status.ok()) << expected.status.ToString();
    ASSERT_TRUE(actual.status.ok()) << actual.status.ToString();
    EXPECT_TRUE(actual.converged);
    EXPECT_NEAR(actual.initial_cost, expected.initial_cost, 1e-10 * expected.initial_cost);
    EXPECT_NEAR(actual.final_cost, expected.final_cost, 1e-8 * expected.final_cost + 1e-16);
    EXPECT_LE(Distance(problem->poses, by_ceres.poses), pose_tolerance);
  }

  // One object for all problems of a test.
  std::unique_ptr<SubproblemSolver<G>> solver_ = MakeBlockSolver<G>();
  std::unique_ptr<SubproblemSolver<G>> ceres_ = MakeCeresSolver<G>();
};

using BlockSolverGroups = testing::Types<SE2, SE3, YawPose>;

}  // namespace hpgo
