// What is learnt along the steps of a solve, and what it saves.
#include "hpgo/ceres/secant_pairs.h"

#include <cmath>
#include <random>
#include <vector>

#include "Eigen/Core"
#include "gtest/gtest.h"
#include "test/ceres/small_problems.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;

std::vector<double> Draw(int n, std::mt19937* random) {
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<double> x(n);
  for (double& v : x) v = number(*random);
  return x;
}

// The Hessian diag(1, 2, ...); the matrix solved with is ten times as stiff.
std::vector<double> Gradient(const std::vector<double>& x) {
  std::vector<double> g = x;
  for (std::size_t k = 0; k < g.size(); ++k) g[k] *= static_cast<double>(k + 1);
  return g;
}
void SolveStiff(double* x, int n) {
  for (int k = 0; k < n; ++k) x[k] /= 10 * (k + 1);
}

TEST(SecantPairs, TheLastStepFollowsFromItsChangeOfTheGradient) {
  constexpr int kSize = 6;
  std::mt19937 random(1);
  SecantPairs pairs;
  const std::vector<double> origin(kSize, 0.);
  for (int k = 0; k < 20; ++k) {  // more than are kept
    const std::vector<double> step = Draw(kSize, &random);
    pairs.Add(step, origin, Gradient(step));
    std::vector<double> x = Gradient(step);
    pairs.Solve([](double* v) { SolveStiff(v, kSize); }, &x);
    for (int c = 0; c < kSize; ++c) EXPECT_NEAR(x[c], step[c], 1e-12);
    // Positive definite whatever is asked.
    const std::vector<double> y = Draw(kSize, &random);
    x = y;
    pairs.Solve([](double* v) { SolveStiff(v, kSize); }, &x);
    double product = 0;
    for (int c = 0; c < kSize; ++c) product += x[c] * y[c];
    EXPECT_GT(product, 0);
  }
}

// However long a solve: memory and the time of a step do not grow with it.
TEST(SecantPairs, AllButTheLastAreForgotten) {
  constexpr int kSize = 8, kMost = 5;
  std::mt19937 random(1);
  const std::vector<double> origin(kSize, 0.);
  SecantPairs all, last;
  for (int k = 0; k < 20; ++k) {
    const std::vector<double> step = Draw(kSize, &random);
    all.Add(step, origin, Gradient(step));
    if (k >= 20 - kMost) last.Add(step, origin, Gradient(step));
  }
  std::vector<double> x = Draw(kSize, &random), y = x;
  all.Solve([](double* v) { SolveStiff(v, kSize); }, &x);
  last.Solve([](double* v) { SolveStiff(v, kSize); }, &y);
  EXPECT_EQ(x, y);
}

TEST(SecantPairs, TakesNoStepAlongWhichTheGradientFalls) {
  SecantPairs pairs;
  pairs.Add({1, 0}, {0, 0}, {-1, 0});
  pairs.Add({0, 0}, {0, 0}, {1, 0});
  pairs.Add({1, 0}, {0, 0}, {std::nan(""), 0});
  EXPECT_TRUE(pairs.empty());
  pairs.Add({1, 0}, {0, 0}, {1, 0});
  EXPECT_FALSE(pairs.empty());
  pairs.Clear();
  EXPECT_TRUE(pairs.empty());
}

// Past the bend of the losses Gauss-Newton's matrix is too stiff: 54 iterations without pairs, as
// Ceres takes, and 30 with one alone.
TEST(SecantPairs, SaveHalfOfTheIterationsWhereLossesBend) {
  GenerateOptions world;
  world.world = World::kCity;
  world.nodes = 2000;
  const PoseGraph<SE2> graph = GenerateGraph<SE2>(world)->graph;
  const auto problem = MakeMapperProblem(Mapper2d::kSlamToolbox, graph);
  const auto twin = MakeMapperProblem(Mapper2d::kSlamToolbox, graph);
  ceres::Solver::Options options = Quiet();
  options.function_tolerance = 1e-8;
  options.max_num_iterations = 200;
  const ceres::Solver::Summary summary = Solved(problem.get(), options);
  ceres::Solver::Summary reference;
  ceres::Solve(options, twin->problem.get(), &reference);
  EXPECT_LE(summary.final_cost, reference.final_cost * (1 + 1e-7));
  EXPECT_LE(2 * summary.iterations.size(), reference.iterations.size());
}

}  // namespace
}  // namespace hpgo
