// The block engine: its steps, what they promise and what they cost.

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "block_solver_fixture.h"
#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "random_problem.h"
#include "small_graphs.h"
#include "small_problems.h"

namespace hpgo {
namespace {

using ceres_costs::PackedSymmetric;
using ceres_costs::RelativePoseTerm;

template <typename G>
class BlockSolverStepsTest : public BlockSolverFixture<G> {};
TYPED_TEST_SUITE(BlockSolverStepsTest, BlockSolverGroups);

TYPED_TEST(BlockSolverStepsTest, ReportsTheCostsOfThePoses) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(20, 0.1, 1).graph);
  const double before = problem.Cost();
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
  ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(summary.initial_cost, before, 1e-11 * before);
  EXPECT_NEAR(summary.final_cost, problem.Cost(), 1e-11 * before);
  EXPECT_LT(summary.final_cost, 0.9 * before);
  EXPECT_GT(summary.seconds, 0);
}

TYPED_TEST(BlockSolverStepsTest, PredictsTheDecreaseOfCeresForAFullStep) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(20, 1e-5, 2).graph);
  Subproblem<G> by_ceres = problem.subproblem;
  const SubproblemOptions options;  // one undamped iteration
  const SubproblemSummary expected = this->ceres_->Solve(options, &by_ceres);
  const SubproblemSummary summary = this->solver_->Solve(options, &problem.subproblem);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_FALSE(summary.damped);
  EXPECT_FALSE(summary.converged);
  const double decrease = summary.initial_cost - summary.final_cost;
  EXPECT_NEAR(summary.predicted_decrease, decrease, 1e-3 * decrease);
  EXPECT_NEAR(summary.predicted_decrease, expected.predicted_decrease, 1e-5 * decrease);
  EXPECT_LE(Distance(problem.subproblem.poses, by_ceres.poses), 1e-8);
}

// Measurements of positions from one pose that cannot move: linear, so that every prediction is
// exact, that of a damped step as well.
TYPED_TEST(BlockSolverStepsTest, PredictsALinearDecreaseExactly) {
  using G = TypeParam;
  for (const double radius : {1e8, 10.0, 0.1}) {
    std::mt19937_64 rng(3);
    typename G::Matrix information = RandomInformation<G>(&rng);
    information.template bottomRows<G::kRotationDof>().setZero();
    information.template rightCols<G::kRotationDof>().setZero();
    Subproblem<G> problem;
    std::vector<RelativePoseTerm<G>> terms(10, {G(), PackedSymmetric<G::kDof>(information)});
    for (int k = 0; k < 10; ++k) {
      terms[k].measurement = RandomPose<G>(&rng, 3, 0);
      Factor<G>& factor = problem.factors.emplace_back();
      factor.term = &terms[k];
      factor.i = 10;
      factor.j = k;
      problem.poses.push_back(RandomPose<G>(&rng, 3, 0));
    }
    problem.poses.emplace_back();
    problem.num_free = 10;
    SubproblemOptions options;
    options.initial_trust_region_radius = radius;
    const SubproblemSummary summary = this->solver_->Solve(options, &problem);
    ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
    EXPECT_EQ(summary.iterations, 1);
    EXPECT_EQ(summary.damped, radius < 1e8);
    const double decrease = summary.initial_cost - summary.final_cost;
    EXPECT_GT(decrease, 0);
    // But for what holds the rotations, which nothing measures.
    EXPECT_NEAR(summary.predicted_decrease, decrease, 1e-11 * summary.initial_cost);
    if (radius == 1e8) {
      EXPECT_LE(summary.final_cost, 1e-20 * summary.initial_cost);
    }
  }
}

// A prior with the residual atan(x): from beyond 1.39 a full step lands farther away. Counts its
// evaluations.
template <typename G>
class AtanPrior : public ceres::CostFunction {
 public:
  AtanPrior() {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->assign(1, G::kParams);
  }
  bool Evaluate(const double* const* x, double* residuals, double** jacobians) const override {
    residuals[0] = std::atan(x[0][0]);
    if (jacobians == nullptr) {
      ++num_costs;
      return true;
    }
    ++num_jacobians;
    std::fill_n(jacobians[0], G::kParams, 0.);
    jacobians[0][0] = 1 / (1 + x[0][0] * x[0][0]);
    return true;
  }
  mutable int num_costs = 0, num_jacobians = 0;
};

TYPED_TEST(BlockSolverStepsTest, AStepThatOvershootsIsShortened) {
  using G = TypeParam;
  constexpr double kStart = 2;
  const double full_step = -std::atan(kStart) * (1 + kStart * kStart);
  AtanPrior<G> cost;
  Subproblem<G> problem;
  typename G::Tangent start = G::Tangent::Zero();
  start[0] = kStart;
  problem.poses.assign(1, G().Retract(start));
  problem.num_free = 1;
  problem.factors.resize(1);
  problem.factors[0].custom = &cost;
  SubproblemOptions options = ToConvergence();
  options.max_iterations = 1;
  const SubproblemSummary summary = this->solver_->Solve(options, &problem);
  EXPECT_TRUE(summary.damped);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
  EXPECT_EQ(cost.num_jacobians, 1);
  EXPECT_EQ(cost.num_costs, 2) << "the full step and a shorter one";
  const double part = (problem.poses[0].data()[0] - kStart) / full_step;
  // What the cubic model of the error gives for the cost at the full step.
  const double missed = std::pow(std::atan(kStart + full_step), 2);
  EXPECT_NEAR(3 * missed * part * part, 2 * (1 - part) * std::pow(std::atan(kStart), 2), 1e-9);
  const double promised = std::atan(kStart) * std::atan(kStart);
  EXPECT_NEAR(summary.predicted_decrease, promised * (2 * part - part * part), 1e-12);

  const SubproblemSummary rest = this->solver_->Solve(ToConvergence(), &problem);
  EXPECT_TRUE(rest.converged);
  EXPECT_NEAR(problem.poses[0].data()[0], 0, 1e-6);
}

// Stiff edges of 10 m behind one that only turns easily, and a measurement by which all of it has
// to swing around that joint: the linear model is exact, if only the steps go along the arcs.
TYPED_TEST(BlockSolverStepsTest, WhatSwingsIsNotStretched) {
  using G = TypeParam;
  constexpr int kPoses = 20;
  typename G::Tangent ahead = G::Tangent::Zero(), turn = G::Tangent::Zero(),
                      stiff = G::Tangent::Constant(1e6);
  ahead[0] = 10;
  turn[G::kDof - 1] = 0.5;
  typename G::Tangent joint = stiff;
  joint[G::kDof - 1] = 1e-6;
  const auto term = [](const G& measurement, const typename G::Tangent& information) {
    return RelativePoseTerm<G>{
        measurement, PackedSymmetric<G::kDof>(typename G::Matrix(information.asDiagonal()))};
  };
  std::vector<RelativePoseTerm<G>> terms;
  Subproblem<G> problem;
  problem.num_free = kPoses;
  const int held = kPoses;
  for (int k = 0; k < kPoses; ++k) {
    problem.poses.push_back(G().Plus(k * ahead));
    terms.push_back(term(k == 0 ? G() : G().Plus(ahead), k == 0 ? joint : stiff));
  }
  problem.poses.emplace_back();
  terms.push_back(term(G().Plus(turn) * problem.poses[kPoses - 1], stiff));
  for (int k = 0; k <= kPoses; ++k) {
    Factor<G>& factor = problem.factors.emplace_back();
    factor.term = &terms[k];
    factor.convention = ceres_costs::ErrorConvention::kTwist;
    factor.i = k == 0 || k == kPoses ? held : k - 1;
    factor.j = k == kPoses ? kPoses - 1 : k;
  }
  const SubproblemSummary summary = this->solver_->Solve(SubproblemOptions(), &problem);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_FALSE(summary.damped);
  EXPECT_LT(summary.final_cost, 1e-9 * summary.initial_cost);
}

TYPED_TEST(BlockSolverStepsTest, TellsItsProgress) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(30, 0.3, 9).graph);
  SubproblemOptions options = ToConvergence();
  std::vector<double> costs;
  options.progress = [&](int iteration, double cost) {
    costs.push_back(cost);
    EXPECT_EQ(iteration, static_cast<int>(costs.size()));
  };
  const SubproblemSummary summary = this->solver_->Solve(options, &problem.subproblem);
  ASSERT_GE(costs.size(), 3u);
  EXPECT_LT(costs[0], summary.initial_cost);
  for (std::size_t k = 1; k < costs.size(); ++k) {
    EXPECT_LE(costs[k], costs[k - 1] * (1 + 1e-13));
  }
  EXPECT_EQ(costs.back(), summary.final_cost);
}

// From so far off that undamped steps raise the cost.
TYPED_TEST(BlockSolverStepsTest, NeverRaisesTheCost) {
  using G = TypeParam;
  bool damped = false;
  for (unsigned seed = 0; seed < 30; ++seed) {
    RandomProblem<G> random(seed);
    std::mt19937_64 rng(seed);
    for (int k = 0; k < random.problem.num_free; ++k) {
      random.problem.poses[k] = random.problem.poses[k] * RandomPose<G>(&rng, 20, 2);
    }
    double last = std::numeric_limits<double>::infinity();
    SubproblemOptions options = ToConvergence();
    options.max_iterations = 50;
    options.progress = [&](int, double cost) {
      EXPECT_LE(cost, last * (1 + 1e-13));
      last = cost;
    };
    const SubproblemSummary summary = this->solver_->Solve(options, &random.problem);
    ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
    EXPECT_LT(summary.final_cost, summary.initial_cost) << seed;
    damped |= summary.damped;
  }
  EXPECT_TRUE(damped);
}

}  // namespace
}  // namespace hpgo
