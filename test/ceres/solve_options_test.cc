// What hpgo::Solve makes of options and callbacks, and what its summary says.
#include <algorithm>
#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/ceres/small_problems.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

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

}  // namespace
}  // namespace hpgo
