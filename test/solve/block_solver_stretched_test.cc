// The block engine where a closure pulls a map apart.

#include "block_solver_fixture.h"
#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "pulled_sheet.h"
#include "small_problems.h"

namespace hpgo {
namespace {

template <typename G>
SubproblemSummary Solve(const PoseGraph<G>& graph, int iterations) {
  Problem<G> problem(graph);
  SubproblemOptions options = ToConvergence();
  options.max_iterations = iterations;
  return MakeBlockSolver<G>()->Solve(options, &problem.subproblem);
}

template <typename G>
class BlockSolverStretchedTest : public testing::Test {};
TYPED_TEST_SUITE(BlockSolverStretchedTest, BlockSolverGroups);

// With Gauss-Newton alone it is 1 % above it in the plane, and 10 % in space.
TYPED_TEST(BlockSolverStretchedTest, TenStepsEndAtTheOptimum) {
  const PoseGraph<TypeParam> graph = PulledSheet<TypeParam>(40);
  EXPECT_LT(Solve(graph, 10).final_cost, 1.0001 * Solve(graph, 300).final_cost);
}

// 124 in space where the model changes only for turns that are too long.
TYPED_TEST(BlockSolverStretchedTest, StepsThatRaiseTheCostTakeTheModelToo) {
  const SubproblemSummary summary = Solve(PulledSheet<TypeParam>(20), 300);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.iterations, 60);
}

// With the model of stretched edges alone it takes 123 iterations in the plane, and 82 in space.
TYPED_TEST(BlockSolverStretchedTest, TheLastStepsAreThoseOfGaussNewton) {
  const SubproblemSummary summary = Solve(PulledSheet<TypeParam>(10), 300);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.iterations, 40);
}

}  // namespace
}  // namespace hpgo
