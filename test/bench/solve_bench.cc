// Full solves, from the file's or the generator's own content to the optimum, for each engine.
//   solve_bench --benchmark_filter='torus3D|city'
// chi2 in the g2o convention and the iterations stand beside the times; init is the share of the
// initial guess.
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "benchmark/benchmark.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/solver_factory.h"

namespace hpgo {
namespace {

template <typename G>
void Solve(benchmark::State& state, const PoseGraph<G>& input, Engine engine) {
  FullSolveOptions options;
  options.engine = engine;
  FullSolveReport report;
  for (auto _ : state) {
    PoseGraph<G> graph = input;
    report = SolveFull(options, &graph);
    if (!report.status.ok()) {
      state.SkipWithError(report.status.ToString().c_str());
      return;
    }
  }
  state.counters["nodes"] = static_cast<double>(input.nodes().size());
  state.counters["edges"] = static_cast<double>(input.edges().size());
  state.counters["chi2"] = report.chi2_after;
  state.counters["iterations"] = report.iterations;
  state.counters["converged"] = report.converged ? 1 : 0;
  state.counters["init_seconds"] = report.init_seconds;
}

void SolveFile(benchmark::State& state, const std::string& path, Engine engine) {
  const Result<AnyGraphFile> file =
      ReadG2o(std::string(HPGO_SHARED_DATA_DIR) + "/" + path, ReadOptions(), nullptr);
  if (!file.ok()) {
    state.SkipWithError(file.status().ToString().c_str());
    return;
  }
  std::visit([&](const auto& graph_file) { Solve(state, graph_file.graph, engine); }, *file);
}

template <typename G>
void SolveWorld(benchmark::State& state, World world, int nodes, Engine engine) {
  GenerateOptions options;
  options.world = world;
  options.nodes = nodes;
  const Result<SyntheticGraph<G>> synthetic = GenerateGraph<G>(options);
  if (!synthetic.ok()) {
    state.SkipWithError(synthetic.status().ToString().c_str());
    return;
  }
  Solve(state, synthetic->graph, engine);
}

void RegisterAll() {
  for (const Engine engine : {Engine::kCeres, Engine::kBlock}) {
    const std::string suffix = std::string("/") + EngineName(engine);
    for (const char* path :
         {"g2o/smallGrid3D.g2o", "g2o/sphere2500.g2o", "g2o/parking-garage.g2o", "g2o/torus3D.g2o",
          "g2o/M3500.g2o", "g2o/intel.g2o", "kitti/graphs/kitti_00.g2o"}) {
      benchmark::RegisterBenchmark((path + suffix).c_str(), SolveFile, path, engine)
          ->Unit(benchmark::kMillisecond);
    }
    for (const int nodes : {1000, 10000, 100000}) {
      for (const World world : {World::kManhattan, World::kCity}) {
        const std::string name =
            std::string(WorldName(world)) + "/" + std::to_string(nodes) + suffix;
        benchmark::RegisterBenchmark(("2d/" + name).c_str(), SolveWorld<SE2>, world, nodes, engine)
            ->Unit(benchmark::kMillisecond);
        benchmark::RegisterBenchmark(("3d/" + name).c_str(), SolveWorld<SE3>, world, nodes, engine)
            ->Unit(benchmark::kMillisecond);
      }
    }
  }
}

[[maybe_unused]] const bool kRegistered = (RegisterAll(), true);

}  // namespace
}  // namespace hpgo
