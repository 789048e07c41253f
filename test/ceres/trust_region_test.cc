// What the rules of the trust region save, in iterations: each bound lies between those with the
// rule and those without it.
#include "hpgo/ceres/trust_region.h"

#include <cstdint>

#include "gtest/gtest.h"
#include "test/ceres/small_problems.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

template <typename G, typename Mapper>
ceres::Solver::Summary Solve(Mapper mapper, const GenerateOptions& options) {
  const auto problem = MakeMapperProblem(mapper, GenerateGraph<G>(options)->graph);
  ceres::Solver::Options solver_options = Quiet();
  solver_options.function_tolerance = 1e-8;
  solver_options.max_num_iterations = 300;
  const ceres::Solver::Summary summary = Solved(problem.get(), solver_options);
  EXPECT_EQ(summary.termination_type, ceres::CONVERGENCE) << summary.message;
  return summary;
}

int Iterations(const ceres::Solver::Summary& summary) {
  return static_cast<int>(summary.iterations.size()) - 1;
}

GenerateOptions World1000(World world, std::uint64_t seed) {
  GenerateOptions options;
  options.world = world;
  options.nodes = 1000;
  options.seed = seed;
  return options;
}

// 30 and 40 iterations; 124 and 157 where Nielsen's rule alone lowers it. The walk is bent so far
// that Gauss-Newton steps fail, and its long chain then needs steps without any damping.
TEST(TrustRegion, DampingThatWeighsNextToNothingGoesAtOnce) {
  GenerateOptions options = World1000(World::kManhattan, 2);
  options.noise_rotation = 0.2;
  options.closure_density = 0.01;
  EXPECT_LE(Iterations(Solve<SE2>(Mapper2d::kCeresExample, options)), 60);
  options.seed = 3;
  options.closure_density = 0.003;
  EXPECT_LE(Iterations(Solve<SE2>(Mapper2d::kCeresExample, options)), 80);
}

// Four and five iterations, each of one trial; six to eight where the first steps, which take
// nearly all of the cost, are learnt from.
TEST(TrustRegion, NothingIsLearntOnTheWay) {
  for (const World world : {World::kManhattan, World::kGrid, World::kCity}) {
    const ceres::Solver::Summary summary = Solve<SE3>(Mapper3d::kCovins, World1000(world, 1));
    EXPECT_LE(Iterations(summary), 5);
    EXPECT_EQ(summary.num_residual_evaluations, Iterations(summary));
  }
}

// 5 iterations; 7 where any of them is learnt from.
TEST(TrustRegion, NothingIsLearntWhereStepsGainWhatTheyPromise) {
  EXPECT_LE(Iterations(Solve<SE3>(Mapper3d::kVins4, World1000(World::kManhattan, 2))), 5);
}

// 11 and 12 iterations; 18 and 17 where such a step is shortened instead.
TEST(TrustRegion, StepWithWhatWasLearntThatFailsIsFoundAgainWithout) {
  GenerateOptions options = World1000(World::kCity, 6);
  options.closure_density = 0.02;
  options.noise_rotation = 0.025;
  EXPECT_LE(Iterations(Solve<SE2>(Mapper2d::kCartographer, options)), 14);
  options.seed = 4;
  EXPECT_LE(Iterations(Solve<SE2>(Mapper2d::kSlamToolbox, options)), 14);
}

// 12 and 13 iterations; 16 each where what was learnt is kept.
TEST(TrustRegion, WhatWasLearntIsForgottenWhereItsStepsGainLittle) {
  GenerateOptions options = World1000(World::kCity, 5);
  options.nodes = 300;
  EXPECT_LE(Iterations(Solve<SE2>(Mapper2d::kCartographer, options)), 14);
  EXPECT_LE(Iterations(Solve<SE3>(Mapper3d::kFuse, World1000(World::kCity, 1))), 14);
}

}  // namespace
}  // namespace hpgo
