// The block engine: where it ends is where Ceres does.

#include "hpgo/solve/block_solver.h"

#include <deque>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "block_solver_fixture.h"
#include "ceres_costs/relative_pose_cost.h"
#include "gtest/gtest.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/solve/ceres_solver.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/window.h"
#include "random_problem.h"
#include "small_graphs.h"
#include "small_hierarchies.h"
#include "small_problems.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;
using ceres_costs::PackedSymmetric;
using ceres_costs::RelativePoseTerm;

template <typename G>
class BlockSolverTest : public BlockSolverFixture<G> {};
TYPED_TEST_SUITE(BlockSolverTest, BlockSolverGroups);

TYPED_TEST(BlockSolverTest, FindsTheOptimumOfCeresOnRandomProblems) {
  for (unsigned seed = 0; seed < 150; ++seed) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    RandomProblem<TypeParam> random(seed);
    this->ExpectEqualToCeres(&random.problem, 1e-3);
    if (testing::Test::HasFailure()) return;
  }
}

TYPED_TEST(BlockSolverTest, FindsTheOptimumOfCeresOnWindows) {
  using G = TypeParam;
  const PoseGraph<G> graph = MakeKnownGraph<G>(300, 0.05, 1).graph;
  HierarchyOptions options;
  options.max_top_nodes = 20;
  Hierarchy<G> hierarchy = MakeHierarchy(graph, options);
  ASSERT_GE(hierarchy.num_levels(), 3);
  Window<G> window;
  for (int l = 0; l < hierarchy.num_levels(); ++l) {
    for (const int max_nodes : {1, 7, 50, 1000}) {
      SCOPED_TRACE(testing::Message() << "level " << l << ", " << max_nodes << " nodes");
      const Index seed = hierarchy.Ancestor(150, l);
      ASSERT_TRUE(window.Build(l, {seed}, {max_nodes, 100000}, &hierarchy));
      this->ExpectEqualToCeres(&window.subproblem(), 1e-5);
    }
  }
}

TYPED_TEST(BlockSolverTest, FullSolvesEndAtTheOptimumOfCeres) {
  using G = TypeParam;
  for (const char* loss : {"none", "huber"}) {
    PoseGraph<G> by_block = MakeKnownGraph<G>(200, 0.05, 2).graph, by_ceres = by_block;
    FullSolveOptions options;
    options.loss = loss;
    options.function_tolerance = 1e-13;
    options.engine = Engine::kCeres;
    const FullSolveReport expected = SolveFull(options, &by_ceres);
    options.engine = Engine::kBlock;
    const FullSolveReport actual = SolveFull(options, &by_block);
    ASSERT_TRUE(expected.status.ok()) << expected.status.ToString();
    ASSERT_TRUE(actual.status.ok()) << actual.status.ToString();
    EXPECT_TRUE(actual.converged);
    EXPECT_NEAR(actual.cost_after, expected.cost_after, 1e-8 * expected.cost_after);
    EXPECT_NEAR(actual.chi2_after, expected.chi2_after, 1e-6 * expected.chi2_after);
  }
}

TYPED_TEST(BlockSolverTest, ConstantPosesStayBitForBit) {
  using G = TypeParam;
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomProblem<G> random(seed);
    const std::vector<G> before = random.problem.poses;
    const auto constant = [&](const std::vector<G>& poses) {
      return std::vector<G>(poses.begin() + random.problem.num_free, poses.end());
    };
    this->solver_->Solve(ToConvergence(), &random.problem);
    EXPECT_TRUE(SameBits(constant(random.problem.poses), constant(before))) << seed;
    EXPECT_FALSE(SameBits(random.problem.poses, before)) << seed;
  }
}

TYPED_TEST(BlockSolverTest, OneObjectSolvesProblemAfterProblem) {
  using G = TypeParam;
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomProblem<G> reused(seed), fresh(seed);
    this->solver_->Solve(ToConvergence(), &reused.problem);
    MakeBlockSolver<G>()->Solve(ToConvergence(), &fresh.problem);
    EXPECT_TRUE(SameBits(reused.problem.poses, fresh.problem.poses)) << seed;
  }
}

TYPED_TEST(BlockSolverTest, ACustomCostGivesTheSameAsItsTerm) {
  using G = TypeParam;
  const PoseGraph<G> graph = MakeKnownGraph<G>(20, 0.1, 3).graph;
  Problem<G> terms(graph), custom(graph);
  std::vector<std::unique_ptr<ceres::CostFunction>> costs;
  for (Factor<G>& factor : custom.subproblem.factors) {
    std::string error;
    costs.push_back(ceres_costs::MakeRelativePoseCost(*factor.term, ErrorConvention::kG2o,
                                                      ceres_costs::DiffMethod::kAutomatic,
                                                      ceres_costs::JacobianKind::kAmbient, &error));
    factor.term = nullptr;
    factor.custom = costs.back().get();
  }
  const SubproblemSummary expected = this->solver_->Solve(ToConvergence(), &terms.subproblem);
  const SubproblemSummary actual = this->solver_->Solve(ToConvergence(), &custom.subproblem);
  EXPECT_NEAR(actual.final_cost, expected.final_cost, 1e-9 * expected.final_cost);
  EXPECT_LE(Distance(custom.subproblem.poses, terms.subproblem.poses), 1e-6);
}

TYPED_TEST(BlockSolverTest, WhatNothingMeasuresStaysWhereItIs) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(8, 0.1, 4).graph);
  // Two nodes without a factor, one of them among the others.
  Subproblem<G>& subproblem = problem.subproblem;
  subproblem.poses.insert(subproblem.poses.begin() + 3, 2, G());
  subproblem.num_free += 2;
  for (Factor<G>& factor : subproblem.factors) {
    factor.i += factor.i >= 3 ? 2 : 0;
    factor.j += factor.j >= 3 ? 2 : 0;
  }
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &subproblem);
  ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_FALSE(summary.damped);
  for (const int k : {3, 4}) EXPECT_EQ(G().LocalCoordinates(subproblem.poses[k]).norm(), 0);

  Problem<G> without(MakeKnownGraph<G>(8, 0.1, 4).graph);
  const SubproblemSummary expected = this->solver_->Solve(ToConvergence(), &without.subproblem);
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-9 * expected.final_cost);
}

// As one that a loss has rejected.
TYPED_TEST(BlockSolverTest, AFactorThatMeasuresNothingHoldsNothing) {
  using G = TypeParam;
  const PoseGraph<G> graph = MakeKnownGraph<G>(20, 0.1, 4).graph;
  Problem<G> with(graph), without(graph);
  const RelativePoseTerm<G> nothing;
  Factor<G> factor;
  factor.term = &nothing;
  factor.i = 2;
  factor.j = 17;
  with.subproblem.factors.push_back(factor);
  const SubproblemSummary expected = this->solver_->Solve(ToConvergence(), &without.subproblem);
  const SubproblemSummary actual = this->solver_->Solve(ToConvergence(), &with.subproblem);
  EXPECT_EQ(actual.iterations, expected.iterations);
  EXPECT_LE(Distance(with.subproblem.poses, without.subproblem.poses), 1e-12);
}

// No pose constant and no prior: the Hessian is singular.
TYPED_TEST(BlockSolverTest, AFreeGaugeIsDamped) {
  using G = TypeParam;
  Problem<G> free(MakeKnownGraph<G>(20, 0.1, 5).graph), held(MakeKnownGraph<G>(20, 0.1, 5).graph);
  free.subproblem.num_free = 20;
  const SubproblemSummary expected = this->solver_->Solve(ToConvergence(), &held.subproblem);
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &free.subproblem);
  ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_NEAR(summary.final_cost, expected.final_cost, 1e-8 * expected.final_cost);
}

// Straight, with one closure from end to end: bending it takes forces of 1e-12 of the diagonal.
TEST(BlockSolverLongChainTest, EndsWhereCeresDoes) {
  constexpr int kNodes = 5000;
  constexpr double kStep = 0.1;
  for (const unsigned seed : {1, 2, 3, 4}) {
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 rng(seed);
    std::normal_distribution<double> shift(0, 0.01), turn(0, 0.005);
    std::deque<RelativePoseTerm<SE2>> terms;
    Subproblem<SE2> problem;
    const auto add = [&](int i, int j, const SE2& measured) {
      terms.push_back({measured, PackedSymmetric<3>(100 * SE2::Matrix::Identity())});
      Factor<SE2>& factor = problem.factors.emplace_back();
      factor.term = &terms.back();
      factor.i = i;
      factor.j = j;
    };
    for (int k = 0; k <= kNodes; ++k) problem.poses.push_back(SE2(kStep * (k - kNodes), 0, 0));
    problem.num_free = kNodes;  // the end is held
    for (int k = 0; k < kNodes; ++k) {
      add(k, k + 1, SE2(kStep + shift(rng), shift(rng), turn(rng)));
    }
    add(0, kNodes, SE2(kStep * kNodes, 0, 0));

    SubproblemOptions options;
    options.max_iterations = 200;
    Subproblem<SE2> by_ceres = problem;
    const SubproblemSummary expected = MakeCeresSolver<SE2>()->Solve(options, &by_ceres);
    const SubproblemSummary actual = MakeBlockSolver<SE2>()->Solve(options, &problem);
    EXPECT_TRUE(expected.converged);
    EXPECT_TRUE(actual.converged) << actual.iterations << " iterations";
    EXPECT_LE(actual.final_cost, expected.final_cost * (1 + 1e-6));
  }
}

}  // namespace
}  // namespace hpgo
