#include "hpgo/solve/simplified_newton.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/chains/span.h"
#include "hpgo/solve/block_solver.h"
#include "pulled_sheet.h"
#include "small_graphs.h"
#include "small_problems.h"

namespace hpgo {
namespace {

template <typename G>
class SimplifiedNewtonTest : public testing::Test {
 protected:
  using Progress = typename SimplifiedNewton<G>::Progress;

  static std::vector<Index> NamesFrom(Index first, const Problem<G>& problem) {
    std::vector<Index> names(problem.subproblem.poses.size());
    std::iota(names.begin(), names.end(), first);
    return names;
  }

  void BeginAndFactor(Problem<G>* problem, const std::vector<Index>& names) {
    ASSERT_TRUE(newton_.Begin(problem->subproblem, names));
    Progress progress = Progress::kUnderWay;
    while (progress == Progress::kUnderWay) progress = newton_.GoOn(1000);
    ASSERT_EQ(progress, Progress::kDone);
  }

  SubproblemSummary Step(Problem<G>* problem, const std::vector<Index>& names) {
    newton_.SetNames(&names);
    return newton_.Solve({}, &problem->subproblem);
  }

  double Optimum(Problem<G>* problem) {
    SubproblemOptions options;
    options.max_iterations = 100;
    return MakeBlockSolver<G>()->Solve(options, &problem->subproblem).final_cost;
  }

  SimplifiedNewton<G> newton_;
};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(SimplifiedNewtonTest, Groups);

TYPED_TEST(SimplifiedNewtonTest, WhereItBeganAStepIsThatOfGaussNewton) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(40, 0.02, 1).graph;
  Problem<TypeParam> problem(graph), other(graph);
  const std::vector<Index> names = this->NamesFrom(7, problem);
  this->BeginAndFactor(&problem, names);
  const SubproblemSummary step = this->Step(&problem, names);
  const SubproblemSummary expected =
      MakeBlockSolver<TypeParam>()->Solve(SubproblemOptions(), &other.subproblem);
  ASSERT_TRUE(step.status.ok());
  EXPECT_LT(Distance(problem.subproblem.poses, other.subproblem.poses), 1e-9);
  EXPECT_LT(step.final_cost, step.initial_cost);
  EXPECT_NEAR(step.initial_cost, expected.initial_cost, 1e-9 * expected.initial_cost);
  EXPECT_NEAR(step.final_cost, expected.final_cost, 1e-9 * expected.initial_cost);
  EXPECT_NEAR(step.final_cost, problem.Cost(), 1e-9 * expected.initial_cost);
  EXPECT_NEAR(step.predicted_decrease, expected.predicted_decrease, 1e-9 * expected.initial_cost);
}

// With Gauss-Newton's model more than half of it is left in space.
TYPED_TEST(SimplifiedNewtonTest, KnowsStretchedEdges) {
  Problem<TypeParam> problem(PulledSheet<TypeParam>(40)), other(PulledSheet<TypeParam>(40));
  SubproblemOptions options;
  options.max_iterations = 3;
  MakeBlockSolver<TypeParam>()->Solve(options, &problem.subproblem);
  const std::vector<Index> names = this->NamesFrom(0, problem);
  this->BeginAndFactor(&problem, names);
  const double before = problem.Cost(), optimum = this->Optimum(&other);
  for (int k = 0; k < 10; ++k) this->Step(&problem, names);
  EXPECT_LT(problem.Cost() - optimum, 0.1 * (before - optimum));
}

TYPED_TEST(SimplifiedNewtonTest, StepsDescendThoughPosesHaveMoved) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(40, 0.02, 2).graph;
  Problem<TypeParam> problem(graph);
  const std::vector<Index> names = this->NamesFrom(0, problem);
  const double optimum = this->Optimum(&problem);
  this->BeginAndFactor(&problem, names);
  for (std::size_t k = 3; k < 12; ++k) {
    TypeParam& pose = problem.subproblem.poses[k];
    pose = pose.Retract(TypeParam::Tangent::Constant(0.01));
  }
  double cost = problem.Cost();
  ASSERT_GT(cost, 1.1 * optimum);
  for (int k = 0; k < 15; ++k) {
    const SubproblemSummary step = this->Step(&problem, names);
    EXPECT_LE(step.final_cost, cost);
    cost = step.final_cost;
  }
  EXPECT_LT(cost, 1.000001 * optimum);
}

TYPED_TEST(SimplifiedNewtonTest, AStepTurnsNothingFurtherThanItReaches) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(40, 0.02, 5).graph;
  Problem<TypeParam> problem(graph);
  const std::vector<Index> names = this->NamesFrom(0, problem);
  this->Optimum(&problem);
  typename TypeParam::Tangent turn = TypeParam::Tangent::Zero();
  turn(TypeParam::kDof - 1) = 1.2;
  std::vector<TypeParam>& poses = problem.subproblem.poses;
  poses[20] = poses[20].Retract(turn);
  const TypeParam before = poses[20];
  this->BeginAndFactor(&problem, names);
  const SubproblemSummary step = this->Step(&problem, names);
  EXPECT_TRUE(step.damped);
  EXPECT_LT(step.final_cost, step.initial_cost);
  EXPECT_LT(before.LocalCoordinates(poses[20]).template tail<TypeParam::kRotationDof>().norm(),
            1.1 * kReach);
}

// Else nothing would, but a prior of next to nothing: the poses would go with the new one for
// miles.
TYPED_TEST(SimplifiedNewtonTest, WhatFollowsHoldsWhatItFollows) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(40, 0.02, 4).graph;
  Problem<TypeParam> problem(graph);
  this->Optimum(&problem);
  std::vector<Factor<TypeParam>>& factors = problem.subproblem.factors;
  const auto is_held = [&](int pose) { return pose >= problem.subproblem.num_free; };
  const auto holds = [&](const Factor<TypeParam>& factor) {
    return is_held(factor.i) || is_held(factor.j);
  };
  factors.erase(std::remove_if(factors.begin(), factors.end(), holds), factors.end());
  std::vector<TypeParam>& poses = problem.subproblem.poses;
  ceres_costs::RelativePoseTerm<TypeParam> prior;
  prior.measurement = poses[0];
  prior.information =
      ceres_costs::PackedSymmetric<TypeParam::kDof>(1e-9 * TypeParam::Matrix::Identity());
  Factor<TypeParam> weak;
  weak.j = 0;
  weak.term = &prior;
  factors.push_back(weak);
  std::vector<Index> names = this->NamesFrom(0, problem);
  this->BeginAndFactor(&problem, names);
  constexpr int kNew = 5;
  names[kNew] = 1000;
  poses[kNew] = poses[kNew].Retract(TypeParam::Tangent::Constant(0.1));
  const std::vector<TypeParam> before = poses;
  const SubproblemSummary step = this->Step(&problem, names);
  EXPECT_LT(step.final_cost, step.initial_cost);
  EXPECT_LT(Distance(poses, before), 10);
}

// With a Hessian that is too soft.
TYPED_TEST(SimplifiedNewtonTest, AStepThatIsTooLongIsShortened) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(40, 0.02, 6).graph;
  Problem<TypeParam> problem(graph);
  const std::vector<Index> names = this->NamesFrom(0, problem);
  this->BeginAndFactor(&problem, names);
  for (auto& term : problem.terms) {
    term.information = ceres_costs::PackedSymmetric<TypeParam::kDof>(3 * term.information.Dense());
  }
  const SubproblemSummary step = this->Step(&problem, names);
  EXPECT_TRUE(step.damped);
  EXPECT_LT(step.final_cost, step.initial_cost);
}

// Another order, and other names for those that are not there.
TYPED_TEST(SimplifiedNewtonTest, PosesAreFoundAgainByTheirNames) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(30, 0.02, 3).graph;
  Problem<TypeParam> problem(graph), turned(graph);
  std::vector<Index> names = this->NamesFrom(0, problem);
  this->BeginAndFactor(&problem, names);
  this->Step(&problem, names);

  const int last_free = turned.subproblem.num_free - 1;
  std::vector<TypeParam>& poses = turned.subproblem.poses;
  std::reverse(poses.begin(), poses.end() - 1);
  std::reverse(names.begin(), names.end() - 1);
  for (Factor<TypeParam>& factor : turned.subproblem.factors) {
    for (int* end : {&factor.i, &factor.j}) {
      if (*end <= last_free) *end = last_free - *end;
    }
  }
  this->Step(&turned, names);
  std::reverse(poses.begin(), poses.end() - 1);
  EXPECT_LT(Distance(problem.subproblem.poses, poses), 1e-9);
}

TYPED_TEST(SimplifiedNewtonTest, NewPosesFollowTheirNeighboursRigidly) {
  const PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(30, 0.02, 4).graph;
  // Of the 30 the system has the first 20, the last of them constant. The others hang on those, one
  // on the other; the very last is constant.
  PoseGraph<TypeParam> part;
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(part.AddNode(graph.nodes()[k]).ok());
  for (const auto& edge : graph.edges()) {
    if (edge.i < 20 && edge.j < 20) {
      ASSERT_TRUE(part.AddEdge(edge).ok());
    }
  }
  Problem<TypeParam> system(part), problem(graph);
  const std::vector<Index> names = this->NamesFrom(0, problem);
  std::vector<Index> system_names(names.begin(), names.begin() + 20);
  this->BeginAndFactor(&system, system_names);
  // Measured within the system only: whatever moves there, nobody pulls at those that follow.
  auto& factors = problem.subproblem.factors;
  const auto is_elsewhere = [](const Factor<TypeParam>& f) {
    return std::max(f.i, f.j) >= 20 && !(f.j == f.i + 1 && f.j < 29);
  };
  factors.erase(std::remove_if(factors.begin(), factors.end(), is_elsewhere), factors.end());
  const std::vector<TypeParam> before = problem.subproblem.poses;
  ASSERT_LT(this->Step(&problem, names).final_cost, CostAt(problem.subproblem, before));
  const std::vector<TypeParam>& after = problem.subproblem.poses;
  EXPECT_GT(before[18].LocalCoordinates(after[18]).norm(), 1e-4);
  for (int k = 18; k < 28; ++k) {
    const TypeParam T_before = before[k].Between(before[k + 1]);
    EXPECT_LT(T_before.LocalCoordinates(after[k].Between(after[k + 1])).norm(), 1e-12) << k;
  }
  EXPECT_EQ(before[29].LocalCoordinates(after[29]).norm(), 0);
}

}  // namespace
}  // namespace hpgo
