#include "hpgo/solve/block_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <thread>

#include "ceres/autodiff_cost_function.h"
#include "ceres_costs/losses.h"
#include "ceres_costs/relative_pose_cost.h"
#include "gtest/gtest.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/solve/ceres_solver.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/window.h"
#include "small_graphs.h"
#include "small_hierarchies.h"
#include "small_problems.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;
using ceres_costs::PackedSymmetric;
using ceres_costs::RelativePoseTerm;

SubproblemOptions ToConvergence() {
  SubproblemOptions options;
  options.max_iterations = 300;
  options.function_tolerance = 1e-13;
  return options;
}

// The distance of two poses from what was measured.
template <typename G>
struct DistanceError {
  double measured;
  template <typename S>
  bool operator()(const S* i, const S* j, S* residual) const {
    using std::sqrt;
    S squares(1e-6);  // smooth at zero
    for (int k = 0; k < G::kDim; ++k) squares += (i[k] - j[k]) * (i[k] - j[k]);
    residual[0] = 3.0 * (sqrt(squares) - measured);
    return true;
  }
};

// A connected graph with everything that factors can have: edges in both directions and parallel,
// also between constant poses; full and partial priors with and without offsets; semi-definite
// edges, losses, custom costs, every convention.
template <typename G>
class RandomProblem {
 public:
  explicit RandomProblem(unsigned seed) : rng_(seed) {
    const int n = Uniform(1, 60), constant = Uniform(0, 3);
    const ErrorConvention convention = static_cast<ErrorConvention>(Uniform(0, 2));
    std::string error;
    EXPECT_TRUE(ceres_costs::MakeLoss("huber", 3, &losses_[1], &error)) << error;
    EXPECT_TRUE(ceres_costs::MakeLoss("cauchy", 5, &losses_[2], &error)) << error;
    std::vector<G> truth;
    for (int k = 0; k < n + constant; ++k) truth.push_back(RandomPose<G>(&rng_, 4, 2));
    const auto edge = [&](int i, int j, bool partial) {
      Factor<G> factor;
      factor.i = i;
      factor.j = j;
      factor.convention = convention;
      factor.loss = losses_[Uniform(0, 2)].get();
      factor.term = Term(truth[i].Between(truth[j]), partial);
      problem.factors.push_back(factor);
    };
    for (int k = 1; k < n; ++k) {
      const int other = Uniform(0, k - 1);
      k % 2 == 0 ? edge(k, other, false) : edge(other, k, false);
    }
    for (int k = 0; k < 2 * n; ++k) {
      const int i = Uniform(0, n + constant - 1), j = Uniform(0, n + constant - 1);
      if (i != j) edge(i, j, k % 3 == 0);
      if (i != j && k % 5 == 0) edge(j, i, false);
    }
    for (int k = n; k < n + constant; ++k) edge(Uniform(0, n - 1), k, false);
    // A constant pose or a prior holds the gauge.
    for (int k = constant > 0 ? Uniform(-2, 2) : 1; k > 0; --k) {
      Factor<G> factor;
      factor.j = Uniform(0, n - 1);
      factor.convention = convention;
      G offset;
      if (k % 2 == 0) {
        offset = RandomPose<G>(&rng_, 1, 1);
        factor.offset = &offsets_.emplace_back(offset);
      }
      const bool partial = k > 1;  // of the position only: with kTwist it would turn with the rest
      factor.term =
          Term(truth[factor.j] * offset, partial && convention != ErrorConvention::kTwist);
      problem.factors.push_back(factor);
    }
    for (int k = 0; k < n / 10; ++k) {
      const int i = Uniform(0, n - 1), j = Uniform(0, n - 1);
      if (i == j) continue;
      const double distance = (truth[i].translation() - truth[j].translation()).norm();
      costs_.push_back(std::make_unique<
                       ceres::AutoDiffCostFunction<DistanceError<G>, 1, G::kParams, G::kParams>>(
          new DistanceError<G>{distance + 0.1}));
      Factor<G> factor;
      factor.i = i;
      factor.j = j;
      factor.custom = costs_.back().get();
      problem.factors.push_back(factor);
    }
    for (int k = 0; k < n + constant; ++k) {
      problem.poses.push_back(k < n ? truth[k] * RandomPose<G>(&rng_, 0.1, 0.1) : truth[k]);
    }
    problem.num_free = n;
  }

  Subproblem<G> problem;

 private:
  int Uniform(int low, int high) { return std::uniform_int_distribution<int>(low, high)(rng_); }

  // Of an edge: noisy, with dense information; `partial`: of the translation alone.
  const RelativePoseTerm<G>* Term(const G& T, bool partial) {
    typename G::Matrix information = 10 * RandomInformation<G>(&rng_);
    if (partial) {
      information.template bottomRows<G::kRotationDof>().setZero();
      information.template rightCols<G::kRotationDof>().setZero();
    }
    return &terms_.emplace_back(RelativePoseTerm<G>{T * RandomPose<G>(&rng_, 0.05, 0.05),
                                                    PackedSymmetric<G::kDof>(information)});
  }

  std::mt19937_64 rng_;
  std::deque<RelativePoseTerm<G>> terms_;
  std::deque<G> offsets_;
  std::unique_ptr<ceres::LossFunction> losses_[3];
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
};

template <typename G>
class BlockSolverTest : public testing::Test {
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
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(BlockSolverTest, Groups);

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

TYPED_TEST(BlockSolverTest, ReportsTheCostsOfThePoses) {
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

TYPED_TEST(BlockSolverTest, PredictsTheDecreaseOfCeresForAFullStep) {
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
TYPED_TEST(BlockSolverTest, PredictsALinearDecreaseExactly) {
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

TYPED_TEST(BlockSolverTest, AStepThatOvershootsIsShortened) {
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

TYPED_TEST(BlockSolverTest, AFailedSolveLeavesThePosesAsTheyWere) {
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

TYPED_TEST(BlockSolverTest, AStartThatIsNotFiniteIsRefused) {
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

TYPED_TEST(BlockSolverTest, StopsWhenCancelled) {
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

TYPED_TEST(BlockSolverTest, StopsAtTheTimeLimit) {
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

TYPED_TEST(BlockSolverTest, StopsAtTheIterationLimit) {
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

TYPED_TEST(BlockSolverTest, TellsItsProgress) {
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
TYPED_TEST(BlockSolverTest, NeverRaisesTheCost) {
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

TYPED_TEST(BlockSolverTest, WithoutFreePosesNothingHappens) {
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
