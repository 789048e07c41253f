// What hpgo::Solve makes of options and callbacks, what it leaves to Ceres, and what it says.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "ceres/autodiff_cost_function.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/ceres/solve.h"
#include "hpgo/generate/synthetic_graph.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

template <typename G>
PoseGraph<G> SmallGraph() {
  GenerateOptions options;
  options.world = World::kManhattan;
  options.nodes = 60;
  options.closure_density = 0.5;
  return GenerateGraph<G>(options)->graph;
}

std::unique_ptr<MapperProblem> Scalars() {
  return MakeMapperProblem(Mapper2d::kCeresExample, SmallGraph<SE2>());
}
std::unique_ptr<MapperProblem> Cartographer() {
  return MakeMapperProblem(Mapper2d::kCartographer, SmallGraph<SE2>());
}
std::unique_ptr<MapperProblem> ThreeD() {
  return MakeMapperProblem(Mapper3d::kCeresExample, SmallGraph<SE3>());
}

ceres::Solver::Options Quiet() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  return options;
}

ceres::Solver::Summary Solved(MapperProblem* problem, const ceres::Solver::Options& options) {
  ceres::Solver::Summary summary;
  hpgo::Solve(options, problem->problem.get(), &summary);
  return summary;
}

// That ceres::Solve was called, for this reason, and did what it does alone.
void ExpectLeftToCeres(MapperProblem* problem, MapperProblem* twin, const std::string& reason,
                       const ceres::Solver::Options& options = Quiet()) {
  const ceres::Solver::Summary summary = Solved(problem, options);
  EXPECT_THAT(summary.message, StartsWith("hpgo: left to ceres::Solve: " + reason + ". "));
  ceres::Solver::Summary reference;
  ceres::Solve(options, twin->problem.get(), &reference);
  EXPECT_EQ(summary.message, "hpgo: left to ceres::Solve: " + reason + ". " + reference.message);
  EXPECT_EQ(summary.termination_type, reference.termination_type);
  EXPECT_EQ(problem->storage, twin->storage);
}

struct Calls final : ceres::IterationCallback {
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    iterations.push_back(summary);
    if (watched != nullptr) seen.push_back(*watched);
    return static_cast<int>(iterations.size()) > end_after ? answer : ceres::SOLVER_CONTINUE;
  }
  std::vector<ceres::IterationSummary> iterations;
  const double* watched = nullptr;
  std::vector<double> seen;
  int end_after = 1 << 20;
  ceres::CallbackReturnType answer = ceres::SOLVER_CONTINUE;
};

TEST(SolveOptions, SummaryReadsAsThatOfCeres) {
  const auto ours = Scalars(), theirs = Scalars();
  const ceres::Solver::Summary summary = Solved(ours.get(), Quiet());
  ceres::Solver::Summary reference;
  ceres::Solve(Quiet(), theirs->problem.get(), &reference);
  EXPECT_TRUE(summary.IsSolutionUsable());
  EXPECT_THAT(summary.message, StartsWith("hpgo: 59 poses (scalars x, y, yaw): "));
  EXPECT_THAT(summary.BriefReport(), StartsWith("Ceres Solver Report: Iterations: "));
  EXPECT_THAT(summary.BriefReport(), HasSubstr("Termination: CONVERGENCE"));
  EXPECT_THAT(summary.FullReport(), HasSubstr("Final"));
  EXPECT_EQ(summary.num_parameter_blocks, reference.num_parameter_blocks);
  EXPECT_EQ(summary.num_parameters, reference.num_parameters);
  EXPECT_EQ(summary.num_effective_parameters, reference.num_effective_parameters);
  EXPECT_EQ(summary.num_residual_blocks, reference.num_residual_blocks);
  EXPECT_EQ(summary.num_residuals, reference.num_residuals);
  EXPECT_EQ(summary.num_parameter_blocks_reduced, reference.num_parameter_blocks_reduced);
  EXPECT_EQ(summary.num_parameters_reduced, reference.num_parameters_reduced);
  EXPECT_EQ(summary.num_effective_parameters_reduced, reference.num_effective_parameters_reduced);
  EXPECT_EQ(summary.num_residual_blocks_reduced, reference.num_residual_blocks_reduced);
  EXPECT_EQ(summary.num_residuals_reduced, reference.num_residuals_reduced);
  EXPECT_EQ(summary.iterations.size(), static_cast<std::size_t>(summary.num_successful_steps +
                                                                summary.num_unsuccessful_steps));
  EXPECT_NEAR(summary.iterations[0].gradient_max_norm, reference.iterations[0].gradient_max_norm,
              1e-9 * reference.iterations[0].gradient_max_norm);
  EXPECT_GE(summary.total_time_in_seconds, summary.minimizer_time_in_seconds);
}

TEST(SolveOptions, FixedCostIsThatOfHeldPoses) {
  for (const bool ours : {true, false}) {
    const auto problem = Cartographer();
    problem->problem->SetParameterBlockConstant(problem->Block(1, 0));
    problem->storage[1][0] += 0.5;
    ceres::Solver::Summary summary;
    if (ours) {
      hpgo::Solve(Quiet(), problem->problem.get(), &summary);
      EXPECT_THAT(summary.message, StartsWith("hpgo: 58 poses"));
    } else {
      ceres::Solve(Quiet(), problem->problem.get(), &summary);
    }
    EXPECT_GT(summary.fixed_cost, 1);
    static double fixed_cost, final_cost;
    if (ours) {
      fixed_cost = summary.fixed_cost;
      final_cost = summary.final_cost;
    } else {
      EXPECT_NEAR(fixed_cost, summary.fixed_cost, 1e-12 * fixed_cost);
      EXPECT_NEAR(final_cost, summary.final_cost, 1e-5 * final_cost);
    }
  }
}

TEST(SolveOptions, IterationLimitEndsUsable) {
  const auto problem = ThreeD();
  ceres::Solver::Options options = Quiet();
  options.max_num_iterations = 1;
  options.function_tolerance = 0;
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  EXPECT_EQ(summary.termination_type, ceres::NO_CONVERGENCE);
  EXPECT_THAT(summary.message, HasSubstr("Maximum number of iterations reached."));
  EXPECT_EQ(summary.iterations.size(), 2u);
  EXPECT_TRUE(summary.IsSolutionUsable());
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

TEST(SolveOptions, NoIterationsMoveNothing) {
  const auto problem = ThreeD();
  const auto before = problem->storage;
  ceres::Solver::Options options = Quiet();
  options.max_num_iterations = 0;
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  EXPECT_EQ(summary.termination_type, ceres::NO_CONVERGENCE);
  EXPECT_EQ(problem->storage, before);
}

TEST(SolveOptions, TimeLimit) {
  const auto problem = ThreeD();
  ceres::Solver::Options options = Quiet();
  options.max_solver_time_in_seconds = 0;
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  EXPECT_EQ(summary.termination_type, ceres::NO_CONVERGENCE);
  EXPECT_THAT(summary.message, HasSubstr("Maximum solver time reached."));
}

TEST(SolveOptions, Tolerances) {
  const auto message = [](double function, double gradient, double parameter) {
    const auto problem = ThreeD();
    ceres::Solver::Options options = Quiet();
    options.function_tolerance = function;
    options.gradient_tolerance = gradient;
    options.parameter_tolerance = parameter;
    return Solved(problem.get(), options).message;
  };
  EXPECT_THAT(message(1e-3, 0, 0), HasSubstr("Function tolerance reached."));
  EXPECT_THAT(message(0, 1e-3, 0), HasSubstr("Gradient tolerance reached."));
  EXPECT_THAT(message(0, 0, 1e-3), HasSubstr("Parameter tolerance reached."));
}

TEST(SolveOptions, CallbacksSeeEveryIterationAndTheStateIfAsked) {
  for (const bool update : {false, true}) {
    const auto problem = Cartographer();
    Calls calls;
    calls.watched = problem->Block(30, 0);
    const double before = *calls.watched;
    ceres::Solver::Options options = Quiet();
    options.callbacks.push_back(&calls);
    options.update_state_every_iteration = update;
    const ceres::Solver::Summary summary = Solved(problem.get(), options);
    ASSERT_EQ(calls.iterations.size(), summary.iterations.size());
    ASSERT_GT(calls.iterations.size(), 2u);
    for (std::size_t k = 0; k < calls.iterations.size(); ++k) {
      EXPECT_EQ(calls.iterations[k].iteration, static_cast<int>(k));
    }
    EXPECT_LE(calls.iterations.back().cost, calls.iterations.front().cost);
    EXPECT_EQ(calls.seen.front(), before);
    EXPECT_EQ(calls.seen.back() == *calls.watched, update);
    EXPECT_NE(*calls.watched, before);
  }
}

TEST(SolveOptions, CallbackEndsTheSolve) {
  const auto problem = Cartographer();
  Calls calls;
  calls.end_after = 1;
  calls.answer = ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  ceres::Solver::Options options = Quiet();
  options.callbacks.push_back(&calls);
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  EXPECT_EQ(summary.termination_type, ceres::USER_SUCCESS);
  EXPECT_EQ(calls.iterations.size(), 2u);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

TEST(SolveOptions, CallbackAborts) {
  const auto problem = Cartographer();
  const auto before = problem->storage;
  Calls calls;
  calls.end_after = 1;
  calls.answer = ceres::SOLVER_ABORT;
  ceres::Solver::Options options = Quiet();
  options.callbacks.push_back(&calls);
  options.update_state_every_iteration = true;
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  EXPECT_EQ(summary.termination_type, ceres::USER_FAILURE);
  EXPECT_FALSE(summary.IsSolutionUsable());
  EXPECT_EQ(problem->storage, before);
}

TEST(SolveOptions, ProgressGoesToStdout) {
  const auto problem = Cartographer();
  ceres::Solver::Options options = Quiet();
  options.logging_type = ceres::PER_MINIMIZER_ITERATION;
  options.minimizer_progress_to_stdout = true;
  ::testing::internal::CaptureStdout();
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  std::fflush(stdout);
  const std::string output = ::testing::internal::GetCapturedStdout();
  EXPECT_THAT(output, StartsWith("iter      cost      cost_change  |gradient|   |step|    "
                                 "tr_ratio  tr_radius  ls_iter  iter_time  total_time\n   0"));
  EXPECT_EQ(std::count(output.begin(), output.end(), '\n'),
            static_cast<int>(summary.iterations.size()) + 1);
}

TEST(SolveFallback, OptionsNotDoneHere) {
  ceres::Solver::Options options = Quiet();
  options.minimizer_type = ceres::LINE_SEARCH;
  ExpectLeftToCeres(Scalars().get(), Scalars().get(), "the options ask for a line search", options);
  options = Quiet();
  options.use_inner_iterations = true;
  // Ceres' own inner iterations do not repeat to the last digit.
  EXPECT_THAT(Solved(Scalars().get(), options).message,
              StartsWith("hpgo: left to ceres::Solve: the options ask for inner iterations. "));
  options = Quiet();
  options.max_num_iterations = -1;
  ExpectLeftToCeres(Scalars().get(), Scalars().get(), "the options are not valid", options);
}

TEST(SolveFallback, NothingToMove) {
  const auto hold = [] {
    auto problem = Cartographer();
    for (std::size_t p = 0; p < problem->storage.size(); ++p) {
      problem->problem->SetParameterBlockConstant(problem->Block(static_cast<int>(p), 0));
    }
    return problem;
  };
  ExpectLeftToCeres(hold().get(), hold().get(), "no residual is over a block that may move");
}

TEST(SolveFallback, Bounds) {
  const auto bound = [] {
    auto problem = Cartographer();
    problem->problem->SetParameterLowerBound(problem->Block(7, 0), 1, -1e3);
    return problem;
  };
  ExpectLeftToCeres(bound().get(), bound().get(),
                    "bounds on a pose: block 1 (size 3) of residual 6");
}

struct Scale {
  template <typename T>
  bool operator()(const T* pose, const T* scale, T* r) const {
    r[0] = pose[0] * (T(1) + T(1e-3) * scale[0]) - T(2);
    return true;
  }
};

TEST(SolveFallback, BlocksThatAreNoPose) {
  const auto add = [] {
    auto problem = Cartographer();
    problem->extra = {{1}};
    problem->problem->AddResidualBlock(new ceres::AutoDiffCostFunction<Scale, 1, 3, 1>(new Scale),
                                       nullptr, problem->Block(3, 0), problem->extra[0].data());
    return problem;
  };
  const std::string name =
      "block 1 (size 1) of residual " + std::to_string(add()->problem->NumResidualBlocks() - 1);
  ExpectLeftToCeres(add().get(), add().get(), name + " belongs to no pose of a block x, y, theta");
  // Constant, it is part of the cost.
  const auto held = add();
  held->problem->SetParameterBlockConstant(held->extra[0].data());
  EXPECT_THAT(Solved(held.get(), Quiet()).message, StartsWith("hpgo: 59 poses"));
  EXPECT_EQ(held->extra[0][0], 1);
}

struct Straight {
  template <typename T>
  bool operator()(const T* a, const T* b, const T* c, T* r) const {
    r[0] = a[0] + c[0] - T(2) * b[0];
    return true;
  }
};

TEST(SolveFallback, ThreePosesInAResidual) {
  const auto add = [] {
    auto problem = Cartographer();
    problem->problem->AddResidualBlock(
        new ceres::AutoDiffCostFunction<Straight, 1, 3, 3, 3>(new Straight), nullptr,
        problem->Block(3, 0), problem->Block(4, 0), problem->Block(5, 0));
    return problem;
  };
  const std::string name = "residual " + std::to_string(add()->problem->NumResidualBlocks() - 1);
  ExpectLeftToCeres(add().get(), add().get(), name + " spans 3 poses");
  // Over one that is held it is over two.
  const auto held = add();
  held->problem->SetParameterBlockConstant(held->Block(4, 0));
  EXPECT_THAT(Solved(held.get(), Quiet()).message, StartsWith("hpgo: 58 poses"));
}

TEST(SolveFallback, QuaternionWithoutManifold) {
  const auto strip = [] {
    auto problem = ThreeD();
    problem->problem->SetManifold(problem->Block(4, 1), nullptr);
    return problem;
  };
  ExpectLeftToCeres(strip().get(), strip().get(),
                    "a pose has 7 degrees of freedom: its quaternion has no manifold");
}

TEST(SolveFallback, ValuesThatAreNotFinite) {
  const auto spoil = [] {
    auto problem = Cartographer();
    problem->storage[5][1] = std::nan("");
    return problem;
  };
  ceres::Solver::Summary summary = Solved(spoil().get(), Quiet());
  EXPECT_THAT(
      summary.message,
      StartsWith("hpgo: left to ceres::Solve: block 1 (size 3) of residual 4 is not finite. "));
  EXPECT_EQ(summary.termination_type, ceres::FAILURE);
}

// Fails, or gives NaN, beyond a distance.
class Failing final : public ceres::CostFunction {
 public:
  Failing(double limit, bool nan) : limit_(limit), nan_(nan) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->push_back(3);
  }
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    r[0] = 0;
    if (J != nullptr && J[0] != nullptr) J[0][0] = J[0][1] = J[0][2] = 0;
    if (x[0][0] <= limit_) return true;
    if (nan_) r[0] = std::nan("");
    return nan_;
  }

 private:
  double limit_;
  bool nan_;
};

TEST(SolveFallback, CostsThatFailAtTheStart) {
  for (const bool nan : {false, true}) {
    const auto problem = Cartographer();
    problem->problem->AddResidualBlock(new Failing(-1e9, nan), nullptr, problem->Block(3, 0));
    const auto before = problem->storage;
    const ceres::Solver::Summary summary = Solved(problem.get(), Quiet());
    EXPECT_THAT(
        summary.message,
        StartsWith("hpgo: left to ceres::Solve: the costs cannot be evaluated at the start"));
    EXPECT_EQ(summary.termination_type, ceres::FAILURE);
    EXPECT_FALSE(summary.IsSolutionUsable());
    EXPECT_EQ(problem->storage, before);
  }
}

TEST(SolveFallback, CostsThatFailOnTheWayShortenTheStep) {
  const auto free = Cartographer();
  Solved(free.get(), Quiet());
  const auto problem = Cartographer();
  const double begin = problem->storage[40][0], end = free->storage[40][0];
  ASSERT_GT(std::abs(end - begin), 1e-6);
  // Fails where the first full step ends.
  const double half = (begin + end) / 2;
  for (const bool nan : {false, true}) {
    const auto hindered = Cartographer();
    if (end > begin) {
      hindered->problem->AddResidualBlock(new Failing(half, nan), nullptr, hindered->Block(40, 0));
    } else {
      GTEST_SKIP() << "the pose moves the other way";
    }
    const ceres::Solver::Summary summary = Solved(hindered.get(), Quiet());
    EXPECT_TRUE(summary.IsSolutionUsable());
    EXPECT_THAT(summary.message, StartsWith("hpgo: 59 poses"));
    EXPECT_LE(hindered->storage[40][0], half);
    EXPECT_LE(summary.final_cost, summary.initial_cost);
  }
}

TEST(SolveLayout, DeclaredSizesAreTheOnlyOnesTried) {
  const auto problem = ThreeD();
  PoseLayout layout;
  layout.sizes = {4, 3};
  ceres::Solver::Summary summary;
  hpgo::Solve(Quiet(), problem->problem.get(), &summary, layout);
  EXPECT_THAT(summary.message,
              StartsWith("hpgo: left to ceres::Solve: block 3 (size 4) of residual 0 belongs to no "
                         "pose of quaternion and translation. "));
  layout.sizes = {3, 4};
  hpgo::Solve(Quiet(), problem->problem.get(), &summary, layout);
  EXPECT_THAT(summary.message, StartsWith("hpgo: 59 poses (translation and quaternion): "));
}

// slam_toolbox leaves blocks of removed nodes behind, their memory freed to be anything.
TEST(SolveLayout, UnusedBlocksAreNotLookedAt) {
  const auto problem = Cartographer();
  problem->extra = {{std::nan(""), 1, 2}};
  problem->problem->AddParameterBlock(problem->extra[0].data(), 3);
  const ceres::Solver::Summary summary = Solved(problem.get(), Quiet());
  EXPECT_THAT(summary.message, StartsWith("hpgo: 59 poses"));
  EXPECT_TRUE(std::isnan(problem->extra[0][0]));
  EXPECT_EQ(problem->extra[0][1], 1);
}

}  // namespace
}  // namespace hpgo
