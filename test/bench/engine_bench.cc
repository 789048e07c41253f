// The block engine against Ceres on the same problems, and where its time goes.
//   engine_bench --benchmark_filter=window     one iteration on windows of 50 to 1000 nodes
//   engine_bench --benchmark_filter=full       from the chordal start to convergence
//   engine_bench --benchmark_filter=part       the steps of one block iteration, one by one
//   engine_bench --benchmark_filter=cholmod    CHOLMOD on the same matrix as part/.../factor
// window and full run the engines by turns, so that a busy machine slows down both: Time is the
// block engine's CPU time, `ceres` and `block` are medians in ms, `speedup` is the median ratio.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "Eigen/CholmodSupport"
#include "benchmark/benchmark.h"
#include "hpgo/solve/block_system.h"
#include "hpgo/solve/solver_factory.h"
#include "test/bench/engine_cases.h"
#include "test/bench/measure.h"

namespace hpgo {
namespace {

template <typename G>
void CompareEngines(benchmark::State& state, MakeCase<G> make, const Name& name) {
  const Case<G> input = make(name.graph, name.level, name.nodes);
  if (!input.status.ok()) return state.SkipWithError(input.status.ToString().c_str());
  constexpr Engine kEngines[2] = {Engine::kCeres, Engine::kBlock};
  const std::unique_ptr<SubproblemSolver<G>> solvers[2] = {MakeSolver<G>(kEngines[0]),
                                                           MakeSolver<G>(kEngines[1])};
  std::vector<double> seconds[2], ratios;
  SubproblemSummary summaries[2];
  Subproblem<G> problem = input.problem;
  for (auto _ : state) {
    for (int k = 0; k < 2; ++k) {
      problem.poses = input.problem.poses;
      const double start = CpuSeconds();
      summaries[k] = solvers[k]->Solve(input.options, &problem);
      seconds[k].push_back(CpuSeconds() - start);
      if (!summaries[k].status.ok()) {
        return state.SkipWithError(summaries[k].status.ToString().c_str());
      }
    }
    ratios.push_back(seconds[0].back() / std::max(1e-6, seconds[1].back()));
    state.SetIterationTime(seconds[1].back());
  }
  state.counters["nodes"] = input.problem.num_free;
  state.counters["factors"] = static_cast<double>(input.problem.factors.size());
  for (int k = 0; k < 2; ++k) {
    const std::string engine = EngineName(kEngines[k]);
    state.counters[engine] = 1e3 * Quantile(seconds[k], 0.5);
    state.counters[engine + "_iterations"] = summaries[k].iterations;
    state.counters[engine + "_cost"] = summaries[k].final_cost;
  }
  state.counters["speedup"] = Quantile(ratios, 0.5);
}

enum class Part { kAnalyze, kLinearize, kFactor, kSolve, kCost };

template <typename G>
void TimePart(benchmark::State& state, MakeCase<G> make, const Name& name, Part part) {
  const Case<G> input = make(name.graph, name.level, name.nodes);
  if (!input.status.ok()) return state.SkipWithError(input.status.ToString().c_str());
  BlockSystem<G> system;
  system.Analyze(&input.problem);
  system.Linearize(Hessian::kHeld);
  if (!system.Factorize(0)) return state.SkipWithError("the Hessian is singular");
  std::vector<double> step = system.gradient();
  for (auto _ : state) {
    switch (part) {
      case Part::kAnalyze:
        system.Analyze(&input.problem);
        break;
      case Part::kLinearize:
        benchmark::DoNotOptimize(system.Linearize(Hessian::kHeld));
        break;
      case Part::kFactor:
        benchmark::DoNotOptimize(system.Factorize(0));
        break;
      case Part::kSolve:
        system.Solve(step.data());
        break;
      case Part::kCost:
        benchmark::DoNotOptimize(system.Cost(input.problem.poses));
        break;
    }
  }
}

// The lower triangle of the Gauss-Newton Hessian, number by number.
template <typename G>
Eigen::SparseMatrix<double> ScalarHessian(const Subproblem<G>& problem) {
  constexpr int D = G::kDof;
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int row, int column, const typename G::Matrix& block) {
    for (int c = 0; c < D; ++c) {
      for (int r = row == column ? c : 0; r < D; ++r) {
        entries.emplace_back(row * D + r, column * D + c, block(r, c));
      }
    }
  };
  for (const Factor<G>& factor : problem.factors) {
    const bool unary = factor.i == kWorldFrame;
    const G& X_j = problem.poses[factor.j];
    const G T = unary ? X_j : problem.poses[factor.i].Between(X_j);
    ceres_costs::QuadraticModel<G> at_j, at_i;
    LinearizeFactor(factor, unary, T, &at_j);
    TransportModel(T.Inverse(), at_j, &at_i);
    const bool free_i = !unary && factor.i < problem.num_free, free_j = factor.j < problem.num_free;
    if (free_j) add(factor.j, factor.j, at_j.A);
    if (free_i) add(factor.i, factor.i, at_i.A);
    if (!free_i || !free_j) continue;
    const typename G::Matrix cross = -at_j.A * T.Inverse().Adjoint();  // row j, column i
    if (factor.j > factor.i) {
      add(factor.j, factor.i, cross);
    } else {
      add(factor.i, factor.j, cross.transpose());
    }
  }
  Eigen::SparseMatrix<double> H(problem.num_free * D, problem.num_free * D);
  H.setFromTriplets(entries.begin(), entries.end());
  return H;
}

template <typename G>
void TimeCholmod(benchmark::State& state, MakeCase<G> make, const Name& name, bool analyze) {
  const Case<G> input = make(name.graph, name.level, name.nodes);
  if (!input.status.ok()) return state.SkipWithError(input.status.ToString().c_str());
  const Eigen::SparseMatrix<double> H = ScalarHessian(input.problem);
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> llt;
  llt.analyzePattern(H);
  for (auto _ : state) analyze ? llt.analyzePattern(H) : llt.factorize(H);
  if (!analyze && llt.info() != Eigen::Success) state.SkipWithError("CHOLMOD failed");
}

template <typename G>
void RegisterParts(MakeCase<G> make, const Name& name, const std::string& label) {
  const std::pair<Part, const char*> parts[] = {{Part::kAnalyze, "/analyze"},
                                                {Part::kLinearize, "/linearize"},
                                                {Part::kFactor, "/factor"},
                                                {Part::kSolve, "/solve"},
                                                {Part::kCost, "/cost"}};
  for (const auto& [part, suffix] : parts) {
    benchmark::RegisterBenchmark(("part/" + label + suffix).c_str(), TimePart<G>, make, name, part)
        ->Unit(benchmark::kMicrosecond)
        ->MeasureProcessCPUTime();
  }
  for (const bool analyze : {true, false}) {
    benchmark::RegisterBenchmark(("cholmod/" + label + (analyze ? "/analyze" : "/factor")).c_str(),
                                 TimeCholmod<G>, make, name, analyze)
        ->Unit(benchmark::kMicrosecond)
        ->MeasureProcessCPUTime();
  }
}

template <typename G>
void RegisterWindows(const std::string& graph, int coarse_level, int largest_coarse) {
  for (const int level : {0, coarse_level}) {
    for (const int nodes : {50, 100, 200, 500, 1000}) {
      if (level > 0 && nodes > largest_coarse) continue;
      const Name name = {graph, level, nodes};
      const std::string label = std::to_string(G::kDim) + "d/" + graph + "/level" +
                                std::to_string(level) + "/" + std::to_string(nodes);
      benchmark::RegisterBenchmark(("window/" + label).c_str(), CompareEngines<G>, MakeWindow<G>,
                                   name)
          ->Unit(benchmark::kMillisecond)
          ->UseManualTime()
          ->MinTime(0.1);
      if (nodes == 100 || nodes == 500) RegisterParts<G>(MakeWindow<G>, name, "window/" + label);
    }
  }
}

template <typename G>
void RegisterFull(const std::string& graph) {
  const std::string label = std::to_string(G::kDim) + "d/" + graph;
  benchmark::RegisterBenchmark(("full/" + label).c_str(), CompareEngines<G>, MakeFull<G>,
                               Name{graph, 0, 0})
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime()
      ->Iterations(3);
  RegisterParts<G>(MakeFull<G>, {graph, 0, 0}, "full/" + label);
}

void RegisterAll() {
  for (const char* world : {"manhattan", "city"}) {
    RegisterWindows<SE2>(world, 2, 1000);
    RegisterWindows<SE3>(world, 2, 1000);
  }
  RegisterWindows<SE3>("sphere2500", 1, 500);
  for (const char* graph : {"sphere2500", "torus3D", "parking-garage", "manhattan"}) {
    RegisterFull<SE3>(graph);
  }
  RegisterFull<SE2>("manhattan");
}

[[maybe_unused]] const bool kRegistered = (RegisterAll(), true);

}  // namespace
}  // namespace hpgo
