// What hpgo::Solve leaves to Ceres and what it says then, costs that fail, declared layouts.
#include <cmath>
#include <string>

#include "ceres/autodiff_cost_function.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/ceres/small_problems.h"

namespace hpgo {
namespace {

using ::testing::StartsWith;

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
