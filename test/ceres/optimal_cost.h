// What tests of hpgo::ProblemSolver compare with.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "ceres/problem.h"
#include "ceres/solver.h"
#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"

namespace hpgo {

// The cost that ceres::Solve ends at, from the values there are; these stay.
inline double OptimalCost(ceres::Problem* problem) {
  std::vector<double*> blocks;
  problem->GetParameterBlocks(&blocks);
  std::vector<std::vector<double>> before;
  for (const double* block : blocks) {
    before.emplace_back(block, block + problem->ParameterBlockSize(block));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.function_tolerance = 1e-12;
  options.max_num_iterations = 200;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, problem, &summary);
  EXPECT_TRUE(summary.IsSolutionUsable()) << summary.message;
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    std::copy(before[b].begin(), before[b].end(), blocks[b]);
  }
  return summary.final_cost;
}

inline double CostOf(ceres::Problem* problem) {
  double cost = std::nan("");
  EXPECT_TRUE(problem->Evaluate({}, &cost, nullptr, nullptr, nullptr));
  return cost;
}

template <typename G>
PoseGraph<G> Graph(int nodes, World world = World::kManhattan) {
  GenerateOptions options;
  options.world = world;
  options.nodes = nodes;
  options.closure_density = 0.4;
  return GenerateGraph<G>(options)->graph;
}

}  // namespace hpgo
