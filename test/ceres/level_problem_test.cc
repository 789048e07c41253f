// Levels as ceres::Problems.
#include "hpgo/ceres/level_problem.h"

#include <memory>
#include <utility>
#include <vector>

#include "Eigen/Eigenvalues"
#include "ceres/covariance.h"
#include "ceres/solver.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/ceres/problem_solver.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/optimizer.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

template <typename G>
PoseGraph<G> Graph() {
  GenerateOptions options;
  options.world = World::kManhattan;
  options.nodes = 300;
  options.closure_density = 0.4;
  return GenerateGraph<G>(options)->graph;
}

// All nodes on level 0, and levels above it.
OptimizerOptions SmallTop() {
  OptimizerOptions options;
  options.condense_chains = false;
  options.max_top_nodes = 20;
  return options;
}

double CostOf(ceres::Problem* problem, int* residuals = nullptr) {
  double cost = -1;
  EXPECT_TRUE(problem->Evaluate({}, &cost, nullptr, nullptr, nullptr));
  if (residuals != nullptr) *residuals = problem->NumResidualBlocks();
  return cost;
}

template <typename G>
class LevelProblemTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(optimizer_.AddGraph(Graph<G>()).ok());
    ASSERT_TRUE(optimizer_.Update().status.ok());
    optimizer_.Refine();
    ASSERT_GE(optimizer_.num_levels(), 2);
  }
  Optimizer<G> optimizer_{SmallTop()};
};
using Groups = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(LevelProblemTest, Groups);

TYPED_TEST(LevelProblemTest, LevelZeroIsTheGraph) {
  const auto level = this->optimizer_.LevelProblem(0);
  ASSERT_TRUE(level.ok()) << level.status().ToString();
  ceres::Problem& problem = (*level)->problem();
  EXPECT_EQ(problem.NumParameterBlocks(), 300);
  EXPECT_EQ(problem.NumResidualBlocks(), static_cast<int>(this->optimizer_.num_edges()));
  EXPECT_NEAR(2 * CostOf(&problem), this->optimizer_.Cost(), 1e-9 * this->optimizer_.Cost());
  for (const NodeId id : {0, 100, 299}) {
    const auto group = this->optimizer_.GetGroup(id, 0);
    const double* block = (*level)->BlockOf(static_cast<Index>(group->id));
    ASSERT_NE(block, nullptr);
    const TypeParam pose = *this->optimizer_.GetPose(id);
    for (int k = 0; k < TypeParam::kParams; ++k) EXPECT_NEAR(block[k], pose.data()[k], 1e-9);
  }
}

// Where the estimate is at rest a level above has nothing to gain: its gradient is that of the
// motions of its groups. Its values are those of the groups.
TYPED_TEST(LevelProblemTest, LevelsAboveAgreeWithTheGroups) {
  for (int l = 1; l < this->optimizer_.num_levels(); ++l) {
    const auto level = this->optimizer_.LevelProblem(l);
    ASSERT_TRUE(level.ok()) << level.status().ToString();
    EXPECT_EQ((*level)->level(), l);
    const auto group = this->optimizer_.GetGroup(150, l);
    const double* block = (*level)->BlockOf(static_cast<Index>(group->id));
    ASSERT_NE(block, nullptr);
    for (int k = 0; k < TypeParam::kParams; ++k) {
      EXPECT_NEAR(block[k], group->pose.data()[k], 1e-9);
    }
    EXPECT_EQ((*level)->edges().size(),
              static_cast<std::size_t>((*level)->problem().NumResidualBlocks()));
    const double before = CostOf(&(*level)->problem());
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &(*level)->problem(), &summary);
    EXPECT_LE(before - summary.final_cost, 1e-3 * this->optimizer_.Cost());
  }
}

TYPED_TEST(LevelProblemTest, CovarianceIsThatOfTheOptimizer) {
  const auto level = this->optimizer_.LevelProblem(0);
  ASSERT_TRUE(level.ok());
  const auto group = this->optimizer_.GetGroup(120, 0);
  const double* block = (*level)->BlockOf(static_cast<Index>(group->id));
  ceres::Covariance::Options options;
  ceres::Covariance covariance(options);
  const std::vector<std::pair<const double*, const double*>> wanted = {{block, block}};
  ASSERT_TRUE(covariance.Compute(wanted, &(*level)->problem()));
  Eigen::Matrix<double, TypeParam::kDof, TypeParam::kDof, Eigen::RowMajor> theirs;
  ASSERT_TRUE(covariance.GetCovarianceBlockInTangentSpace(block, block, theirs.data()));
  const auto ours = this->optimizer_.MarginalCovariance(120);
  ASSERT_TRUE(ours.ok());
  EXPECT_LE((theirs - *ours).norm(), 1e-6 * ours->norm());
}

// With chains condensed level 0 is the kept nodes; a chain alone costs nothing where it is at rest.
TYPED_TEST(LevelProblemTest, CondensedChainsAreEdgesOfLevelZero) {
  Optimizer<TypeParam> optimizer;
  GenerateOptions options;
  options.world = World::kCity;
  options.nodes = 300;
  options.closure_density = 0.05;
  ASSERT_TRUE(optimizer.AddGraph(GenerateGraph<TypeParam>(options)->graph).ok());
  ASSERT_TRUE(optimizer.Update().status.ok());
  optimizer.Refine();
  const auto level = optimizer.LevelProblem(0);
  ASSERT_TRUE(level.ok());
  EXPECT_LT((*level)->problem().NumParameterBlocks(), 100);
  EXPECT_NEAR(2 * CostOf(&(*level)->problem()), optimizer.Cost(), 1e-2 * optimizer.Cost());
}

TYPED_TEST(LevelProblemTest, NoSuchLevel) {
  for (const int l : {-1, this->optimizer_.num_levels()}) {
    const auto level = this->optimizer_.LevelProblem(l);
    EXPECT_EQ(level.status().code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(level.status().message(), ::testing::StartsWith("there is no level "));
  }
}

TEST(LevelProblem, OfAProblemSolver) {
  const auto made = MakeMapperProblem(Mapper3d::kFuse, Graph<SE3>());
  ProblemSolverOptions options;
  options.optimizer = SmallTop();
  ProblemSolver solver(made->problem.get(), options);
  EXPECT_EQ(solver.LevelProblem<SE3>(0).status().code(), StatusCode::kInvalidArgument);
  solver.Refine();
  ASSERT_EQ(solver.why_not_kept(), "");
  EXPECT_EQ(solver.LevelProblem<SE2>(0).status().message(),
            "the problem's poses are of another group");
  const auto level = solver.LevelProblem<SE3>(0);
  ASSERT_TRUE(level.ok()) << level.status().ToString();
  EXPECT_NEAR(CostOf(&(*level)->problem()), CostOf(made->problem.get()),
              1e-6 * CostOf(made->problem.get()));
  const auto group = solver.GroupOf(made->Block(77, 1), 0);
  ASSERT_TRUE(group.ok());
  const double* block = (*level)->BlockOf(static_cast<Index>(*group));
  ASSERT_NE(block, nullptr);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(block[k], made->Block(77, 0)[k], 1e-6);
  double stranger = 0;
  EXPECT_EQ(solver.GroupOf(&stranger, 0).status().code(), StatusCode::kNotFound);
}

}  // namespace
}  // namespace hpgo
