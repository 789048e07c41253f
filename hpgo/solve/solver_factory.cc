#include "hpgo/solve/solver_factory.h"

#include "hpgo/solve/block_solver.h"
#include "hpgo/solve/ceres_solver.h"

namespace hpgo {

const char* EngineName(Engine engine) { return engine == Engine::kCeres ? "ceres" : "block"; }

std::optional<Engine> ParseEngine(const std::string& name) {
  for (const Engine engine : {Engine::kCeres, Engine::kBlock}) {
    if (name == EngineName(engine)) return engine;
  }
  return std::nullopt;
}

template <typename G>
std::unique_ptr<SubproblemSolver<G>> MakeSolver(Engine engine) {
  return engine == Engine::kCeres ? MakeCeresSolver<G>() : MakeBlockSolver<G>();
}

template std::unique_ptr<SubproblemSolver<ceres_costs::SE2>> MakeSolver(Engine);
template std::unique_ptr<SubproblemSolver<ceres_costs::SE3>> MakeSolver(Engine);
template std::unique_ptr<SubproblemSolver<ceres_costs::YawPose>> MakeSolver(Engine);

}  // namespace hpgo
