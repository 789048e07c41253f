// Small problems for tests of hpgo::Solve.
#pragma once

#include <memory>

#include "ceres/solver.h"
#include "hpgo/ceres/solve.h"
#include "hpgo/generate/synthetic_graph.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {

template <typename G>
PoseGraph<G> SmallGraph() {
  GenerateOptions options;
  options.world = World::kManhattan;
  options.nodes = 60;
  options.closure_density = 0.5;
  return GenerateGraph<G>(options)->graph;
}

inline std::unique_ptr<MapperProblem> Scalars() {
  return MakeMapperProblem(Mapper2d::kCeresExample, SmallGraph<ceres_costs::SE2>());
}
inline std::unique_ptr<MapperProblem> Cartographer() {
  return MakeMapperProblem(Mapper2d::kCartographer, SmallGraph<ceres_costs::SE2>());
}
inline std::unique_ptr<MapperProblem> ThreeD() {
  return MakeMapperProblem(Mapper3d::kCeresExample, SmallGraph<ceres_costs::SE3>());
}

inline ceres::Solver::Options Quiet() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  return options;
}

inline ceres::Solver::Summary Solved(MapperProblem* problem,
                                     const ceres::Solver::Options& options) {
  ceres::Solver::Summary summary;
  hpgo::Solve(options, problem->problem.get(), &summary);
  return summary;
}

}  // namespace hpgo
