#include "hpgo/solve/ceres_solver.h"

#include <cstring>
#include <string>

#include "ceres_costs/losses.h"
#include "ceres_costs/relative_pose_cost.h"
#include "gtest/gtest.h"
#include "small_graphs.h"
#include "small_problems.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;
using ceres_costs::PackedSymmetric;
using ceres_costs::RelativePoseTerm;

SubproblemOptions ToConvergence() {
  SubproblemOptions options;
  options.max_iterations = 100;
  return options;
}

template <typename G>
class CeresSolverTest : public ::testing::Test {
 protected:
  std::unique_ptr<SubproblemSolver<G>> solver_ = MakeCeresSolver<G>();
};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(CeresSolverTest, Groups);

TYPED_TEST(CeresSolverTest, ReportsCostsWithoutTheHalf) {
  Problem<TypeParam> problem(MakeKnownGraph<TypeParam>(20, 0.1, 1).graph);
  const TypeParam constant = problem.subproblem.poses.back();
  const double before = problem.Cost();
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
  ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_TRUE(summary.converged);
  EXPECT_NEAR(summary.initial_cost, before, 1e-9 * before);
  EXPECT_NEAR(summary.final_cost, problem.Cost(), 1e-9 * before);
  EXPECT_LT(summary.final_cost, 0.9 * before);
  EXPECT_EQ(std::memcmp(constant.data(), problem.subproblem.poses.back().data(),
                        sizeof(double) * TypeParam::kParams),
            0);
}

TYPED_TEST(CeresSolverTest, ASmallStepDecreasesTheCostAsPredicted) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(20, 1e-5, 2).graph);
  SubproblemOptions options;
  const SubproblemSummary summary = this->solver_->Solve(options, &problem.subproblem);
  EXPECT_EQ(summary.iterations, 1);
  EXPECT_FALSE(summary.damped);
  const double decrease = summary.initial_cost - summary.final_cost;
  EXPECT_GT(decrease, 0);
  EXPECT_NEAR(summary.predicted_decrease, decrease, 1e-3 * decrease);
}

TYPED_TEST(CeresSolverTest, OneObjectSolvesProblemAfterProblem) {
  using G = TypeParam;
  for (const int nodes : {30, 10, 40}) {
    Problem<G> reused(MakeKnownGraph<G>(nodes, 0.1, nodes).graph);
    Problem<G> fresh(MakeKnownGraph<G>(nodes, 0.1, nodes).graph);
    this->solver_->Solve(ToConvergence(), &reused.subproblem);
    MakeCeresSolver<G>()->Solve(ToConvergence(), &fresh.subproblem);
    EXPECT_TRUE(SameBits(reused.subproblem.poses, fresh.subproblem.poses)) << nodes;
  }
}

TYPED_TEST(CeresSolverTest, ACustomCostGivesTheSameAsItsTerm) {
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
  EXPECT_LT(Distance(custom.subproblem.poses, terms.subproblem.poses), 1e-5);
}

TYPED_TEST(CeresSolverTest, APriorPullsThroughItsOffset) {
  using G = TypeParam;
  std::mt19937_64 rng(4);
  const G truth = RandomPose<G>(&rng, 3, 2), offset = RandomPose<G>(&rng, 1, 1);
  const RelativePoseTerm<G> term = {truth * offset,
                                    PackedSymmetric<G::kDof>(RandomInformation<G>(&rng))};
  Subproblem<G> problem;
  problem.poses.push_back(truth * RandomPose<G>(&rng, 0.3, 0.3));
  problem.num_free = 1;
  Factor<G>& factor = problem.factors.emplace_back();
  factor.term = &term;
  factor.offset = &offset;
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem);
  ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
  EXPECT_LT(truth.LocalCoordinates(problem.poses[0]).norm(), 1e-7);
  EXPECT_LT(summary.final_cost, 1e-12);
}

TYPED_TEST(CeresSolverTest, ALossBoundsTheCostOfAFactor) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(10, 0.1, 5).graph);
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  ASSERT_TRUE(ceres_costs::MakeLoss("cauchy", 0.1, &loss, &error));
  for (Factor<G>& factor : problem.subproblem.factors) factor.loss = loss.get();
  const double before = problem.Cost();
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
  EXPECT_NEAR(summary.initial_cost, before, 1e-9 * before);
  EXPECT_NEAR(summary.final_cost, problem.Cost(), 1e-9 * before);
}

TYPED_TEST(CeresSolverTest, AnIndefiniteInformationIsRefused) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(5, 0.1, 6).graph);
  problem.terms[2].information.data()[0] = -1;
  const std::vector<G> before = problem.subproblem.poses;
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
  EXPECT_EQ(summary.status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(summary.status.message(),
            "the factor between poses 2 and 3: information is not positive semi-definite");
  EXPECT_TRUE(SameBits(problem.subproblem.poses, before));
}

TYPED_TEST(CeresSolverTest, AFailedSolveLeavesThePosesAsTheyWere) {
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
    EXPECT_EQ(summary.final_cost, summary.initial_cost);
    EXPECT_EQ(summary.status.code(), good == 0 ? StatusCode::kNoSolution : StatusCode::kOk);
    EXPECT_EQ(summary.status.message().empty(), good == 1);
    EXPECT_TRUE(SameBits(problem.subproblem.poses, before)) << good;
  }
}

TYPED_TEST(CeresSolverTest, ACostOverOtherBlocksIsRefused) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(5, 0.1, 8).graph);
  const FailingCost<G> cost(0);
  Factor<G>& factor = problem.subproblem.factors.emplace_back();
  factor.j = 1;
  factor.custom = &cost;
  const SubproblemSummary summary = this->solver_->Solve(ToConvergence(), &problem.subproblem);
  EXPECT_EQ(summary.status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(summary.status.message(),
            "the factor between poses -1 and 1: the cost's parameter blocks are not these poses");
}

TYPED_TEST(CeresSolverTest, StopsWhenCancelled) {
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
}

TYPED_TEST(CeresSolverTest, WithoutFreePosesNothingHappens) {
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
