// What hpgo::ProblemSolver recognizes and keeps of a problem, and what it does not.
#include "hpgo/ceres/problem_solver.h"

#include <vector>

#include "ceres/autodiff_cost_function.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/ceres/level_problem.h"
#include "test/ceres/mapper_problems.h"
#include "test/ceres/optimal_cost.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

template <typename Mapper, typename G>
void ExpectKept(Mapper mapper, const PoseGraph<G>& graph) {
  SCOPED_TRACE(MapperName(mapper));
  const auto made = MakeMapperProblem(mapper, graph);
  ProblemSolver solver(made->problem.get());
  const double optimal = OptimalCost(made->problem.get());
  const auto before = made->storage[0];
  EXPECT_TRUE(solver.Update().status.ok());
  EXPECT_EQ(solver.why_not_kept(), "");
  EXPECT_TRUE(solver.Refine().status.ok());
  EXPECT_LE(CostOf(made->problem.get()), optimal * (1 + 1e-4));
  if (made->problem->IsParameterBlockConstant(made->Block(0, 0))) {
    EXPECT_EQ(made->storage[0], before);
  }
}

TEST(ProblemSolver, KeepsPlanarProblems) {
  for (const Mapper2d mapper : kMappers2d) ExpectKept(mapper, Graph<SE2>(150));
}

TEST(ProblemSolver, KeepsSpatialProblems) {
  for (const Mapper3d mapper :
       {Mapper3d::kCeresExample, Mapper3d::kVins6, Mapper3d::kVinsGlobal, Mapper3d::kFuse,
        Mapper3d::kOkvis, Mapper3d::kOv2slam, Mapper3d::kCovins, Mapper3d::kOpenLidarMap}) {
    ExpectKept(mapper, Graph<SE3>(100));
  }
}

TEST(ProblemSolver, KeepsGravityAlignedProblems) {
  for (const Mapper3d mapper : {Mapper3d::kVins4, Mapper3d::kVoxgraph}) {
    ExpectKept(mapper, Graph<SE3>(100));
  }
}

// The poses of level 0 beside those of the problem: a cost that is a measurement in some convention
// becomes a part of a chain, whatever its code.
template <typename G, typename Mapper>
double KeptShare(Mapper mapper) {
  constexpr int kNodes = 400;
  const auto made = MakeMapperProblem(mapper, Graph<G>(kNodes, World::kCity));
  ProblemSolver solver(made->problem.get());
  EXPECT_TRUE(solver.Update().status.ok());
  const auto level = solver.LevelProblem<G>(0);
  EXPECT_TRUE(level.ok()) << solver.why_not_kept();
  return level.ok() ? 1. * (*level)->problem().NumParameterBlocks() / kNodes : 1;
}

TEST(ProblemSolver, CondensesCostsThatAreMeasurements) {
  constexpr double kCondensed = 0.3;
  for (const Mapper2d mapper :
       {Mapper2d::kCeresExample, Mapper2d::kRtabMap, Mapper2d::kCartographer}) {
    EXPECT_LT(KeptShare<SE2>(mapper), kCondensed) << MapperName(mapper);
  }
  for (const Mapper3d mapper : {Mapper3d::kCeresExample, Mapper3d::kVins6, Mapper3d::kVinsGlobal,
                                Mapper3d::kOkvis, Mapper3d::kOv2slam, Mapper3d::kOpenLidarMap}) {
    EXPECT_LT(KeptShare<SE3>(mapper), kCondensed) << MapperName(mapper);
  }
}

TEST(ProblemSolver, CondensesNoOthers) {
  // Losses on odometry; a lever arm in the cost, whose error is none of the conventions'.
  EXPECT_EQ(KeptShare<SE2>(Mapper2d::kSlamToolbox), 1);
  EXPECT_EQ(KeptShare<SE3>(Mapper3d::kFuse), 1);
  EXPECT_GT(KeptShare<SE3>(Mapper3d::kCovins), 0.9);
}

struct ByBlock {
  template <typename T>
  bool operator()(const T* a, const T* b, const T* z, T* r) const {
    const T c = ceres::cos(a[2]), s = ceres::sin(a[2]), dx = b[0] - a[0], dy = b[1] - a[1];
    r[0] = c * dx + s * dy - z[0];
    r[1] = -s * dx + c * dy - z[1];
    r[2] = ceres_costs::NormalizeAngle(T(b[2] - a[2] - z[2]));
    return true;
  }
};

// A measurement whose values are a held block: whoever rewrites it changes the objective.
TEST(ProblemSolver, ReadsHeldBlocksAnew) {
  for (const bool watch : {false, true}) {
    std::vector<std::vector<double>> poses(4, std::vector<double>(3, 0));
    // Of a size that no pose has.
    std::vector<double> z = {1, 0, 0.1, 0};
    ceres::Problem problem;
    for (int k = 0; k < 3; ++k) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<ByBlock, 3, 3, 3, 4>(new ByBlock),
                               nullptr, poses[k].data(), poses[k + 1].data(), z.data());
    }
    problem.SetParameterBlockConstant(poses[0].data());
    problem.SetParameterBlockConstant(z.data());
    ProblemSolverOptions options;
    options.watch = watch;
    ProblemSolver solver(&problem, options);
    EXPECT_TRUE(solver.Refine().status.ok());
    ASSERT_EQ(solver.why_not_kept(), "");
    EXPECT_NEAR(solver.Cost(), 0, 1e-9);
    z[0] = 2;
    EXPECT_NEAR(solver.Cost(), CostOf(&problem), 1e-9);
    EXPECT_NEAR(solver.Cost(), 1.5, 1e-6);
  }
}

TEST(ProblemSolver, RecognizesLayouts) {
  const auto layout_of = [](Mapper3d mapper) {
    const auto made = MakeMapperProblem(mapper, Graph<SE3>(40));
    ProblemSolver solver(made->problem.get());
    EXPECT_TRUE(solver.Update().status.ok());
    EXPECT_EQ(solver.why_not_kept(), "") << MapperName(mapper);
    return solver.layout() == nullptr ? PoseLayout() : *solver.layout();
  };
  using Quaternion = PoseLayout::Quaternion;
  PoseLayout layout = layout_of(Mapper3d::kCeresExample);
  EXPECT_EQ(layout.sizes, (std::vector<int>{3, 4}));
  EXPECT_EQ(layout.quaternion, Quaternion::kWLast);
  EXPECT_EQ(layout.direction, PoseLayout::Direction::kWorldNode);
  layout = layout_of(Mapper3d::kVins6);
  EXPECT_EQ(layout.sizes, (std::vector<int>{4, 3}));
  EXPECT_EQ(layout.quaternion, Quaternion::kWFirst);
  layout = layout_of(Mapper3d::kFuse);
  EXPECT_EQ(layout.quaternion, Quaternion::kWFirst);
  layout = layout_of(Mapper3d::kOv2slam);
  EXPECT_EQ(layout.translation_at, 0);
  EXPECT_EQ(layout.quaternion, Quaternion::kWLast);
  layout = layout_of(Mapper3d::kCovins);
  EXPECT_EQ(layout.translation_at, 4);
  EXPECT_EQ(layout.rotation_at, 0);
  layout = layout_of(Mapper3d::kVins4);
  EXPECT_EQ(layout.kind, PoseLayout::Kind::kXYZYaw);
  EXPECT_EQ(layout.angle, PoseLayout::AngleUnit::kDegrees);
  EXPECT_EQ(layout.translation_at, 1);
  EXPECT_EQ(layout.rotation_at, 0);
  layout = layout_of(Mapper3d::kVoxgraph);
  EXPECT_EQ(layout.kind, PoseLayout::Kind::kXYZYaw);
  EXPECT_EQ(layout.angle, PoseLayout::AngleUnit::kRadians);
  EXPECT_EQ(layout.translation_at, 0);
  EXPECT_EQ(layout.rotation_at, 3);
}

// What is not kept is solved whole, and says why.
TEST(ProblemSolver, WhatIsNotKept) {
  const auto reason = [](MapperProblem* made) {
    const double optimal = OptimalCost(made->problem.get());
    ProblemSolver solver(made->problem.get());
    EXPECT_TRUE(solver.Update().status.ok());
    EXPECT_LE(CostOf(made->problem.get()), optimal * (1 + 1e-3));
    EXPECT_EQ(solver.layout(), nullptr);
    EXPECT_TRUE(std::isnan(solver.Cost()));
    return solver.why_not_kept();
  };
  EXPECT_EQ(reason(MakeMapperProblem(Mapper3d::kCartographer, Graph<SE3>(60)).get()),
            "pose partly constant");
  ceres::Problem empty;
  ProblemSolver solver(&empty);
  EXPECT_TRUE(solver.Update().status.ok());
  EXPECT_EQ(solver.why_not_kept(), "there is no residual");
}

}  // namespace
}  // namespace hpgo
