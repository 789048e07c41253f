// The block engine: failures, limits, and nothing to do.

#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "block_solver_fixture.h"
#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "random_problem.h"
#include "small_graphs.h"
#include "small_problems.h"

namespace hpgo {
namespace {

template <typename G>
class BlockSolverEndsTest : public BlockSolverFixture<G> {};
TYPED_TEST_SUITE(BlockSolverEndsTest, BlockSolverGroups);

TYPED_TEST(BlockSolverEndsTest, AFailedSolveLeavesThePosesAsTheyWere) {
  using G = TypeParam;
  for (const int good : {0, 1}) {  // fails at the start, at every step
    Problem<G> problem(MakeKnownGraph<G>(5, 0.1, 7).graph);
    const FailingCost<G> cost(good);
    Factor<G>& factor = problem.subproblem.factors.emplace_back();
    factor.i = 0;
    factor.j = 1;
    factor.custom = &cost;
    const std::vector<G> before = problem.subproblem.poses;
    const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
    EXPECT_EQ(summary.status.code(), good == 0 ? StatusCode::kNoSolution : StatusCode::kOk);
    EXPECT_EQ(summary.status.message(), good == 0 ? "the cost is not finite at the start" : "");
    EXPECT_TRUE(SameBits(problem.subproblem.poses, before)) << good;
    EXPECT_FALSE(summary.converged) << good;
    if (good == 1) {
      EXPECT_EQ(summary.final_cost, summary.initial_cost);
    }
  }
}

TYPED_TEST(BlockSolverEndsTest, AStartThatIsNotFiniteIsRefused) {
  using G = TypeParam;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    for (const int node : {0, 3, 6}) {  // the last one is constant
      Problem<G> problem(MakeKnownGraph<G>(7, 0.1, 8).graph);
      problem.subproblem.poses[node].translation()(1) = bad;
      const std::vector<G> before = problem.subproblem.poses;
      const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
      EXPECT_EQ(summary.status.code(), StatusCode::kNoSolution);
      EXPECT_EQ(summary.status.message(), "the cost is not finite at the start");
      EXPECT_TRUE(SameBits(problem.subproblem.poses, before));
    }
  }
  // The object is as good as new.
  RandomProblem<G> random(1);
  this->ExpectEqualToCeres(&random.problem, 1e-3);
}

TYPED_TEST(BlockSolverEndsTest, StopsWhenCancelled) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(30, 0.1, 9).graph);
  std::atomic<bool> cancel(false);
  SubproblemOptions options = ToConvergence();
  options.cancel = &cancel;
  options.progress = [&](int, double) { cancel = true; };
  const SubproblemSummary summary = this->solver_->Solve(options, &problem.subproblem);
  EXPECT_EQ(summary.status.code(), StatusCode::kInterrupted);
  EXPECT_FALSE(summary.converged);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_NEAR(problem.Cost(), summary.final_cost, 1e-9 * summary.final_cost);

  const std::vector<G> before = problem.subproblem.poses;
  const SubproblemSummary again = this->solver_->Solve(options, &problem.subproblem);
  EXPECT_EQ(again.status.code(), StatusCode::kInterrupted);
  EXPECT_EQ(again.iterations, 0);
  EXPECT_TRUE(SameBits(problem.subproblem.poses, before));
}

TYPED_TEST(BlockSolverEndsTest, StopsAtTheTimeLimit) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(30, 0.1, 9).graph);
  SubproblemOptions options = ToConvergence();
  options.max_seconds = 0.5;
  options.progress = [](int, double) {
    std::this_thread::sleep_for(std::chrono::milliseconds(501));
  };
  const SubproblemSummary summary = this->solver_->Solve(options, &problem.subproblem);
  EXPECT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_FALSE(summary.converged);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_GE(summary.seconds, 0.5);
}

TYPED_TEST(BlockSolverEndsTest, StopsAtTheIterationLimit) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(30, 0.3, 9).graph);
  SubproblemOptions options = ToConvergence();
  for (const int limit : {0, 1, 2}) {
    options.max_iterations = limit;
    const SubproblemSummary summary = this->solver_->Solve(options, &problem.subproblem);
    EXPECT_TRUE(summary.status.ok()) << summary.status.ToString();
    EXPECT_FALSE(summary.converged);
    EXPECT_EQ(summary.iterations, limit);
    EXPECT_NEAR(problem.Cost(), summary.final_cost, 1e-9 * summary.final_cost);
  }
}

TYPED_TEST(BlockSolverEndsTest, WithoutFreePosesNothingHappens) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(5, 0.1, 10).graph);
  problem.subproblem.num_free = 0;
  const std::vector<G> before = problem.subproblem.poses;
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
  EXPECT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_TRUE(SameBits(problem.subproblem.poses, before));
  EXPECT_NEAR(summary.final_cost, problem.Cost(), 1e-9);
}

}  // namespace
}  // namespace hpgo
