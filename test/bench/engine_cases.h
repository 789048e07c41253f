// The problems that the engines are compared on: windows of a level, and whole graphs.
#pragma once

#include <map>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/graph/components.h"
#include "hpgo/graph/pose_graph.h"
#include "hpgo/graph/status.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/solve/full_problem.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/initial_guess.h"
#include "hpgo/solve/window.h"
#include "test/solve/small_hierarchies.h"

namespace hpgo {

inline constexpr int kWorldNodes = 10000;

// "manhattan", "city": generated, with the truth as its poses if `near_optimum`; otherwise a g2o
// file, a little off its optimum: at the optimum itself Ceres stops without a step.
template <typename G>
Result<PoseGraph<G>> MakeGraph(const std::string& name, bool near_optimum) {
  if (const Result<World> world = ParseWorld(name); world.ok()) {
    GenerateOptions options;
    options.world = *world;
    options.nodes = kWorldNodes;
    Result<SyntheticGraph<G>> synthetic = GenerateGraph<G>(options);
    if (!synthetic.ok()) return synthetic.status();
    for (int k = 0; near_optimum && k < kWorldNodes; ++k) {
      synthetic->graph.node(k).pose = synthetic->truth[k];
    }
    return std::move(synthetic->graph);
  }
  Result<AnyGraphFile> file =
      ReadG2o(std::string(HPGO_SHARED_DATA_DIR) + "/g2o/" + name + ".g2o", ReadOptions(), nullptr);
  if (!file.ok()) return file.status();
  PoseGraph<G> graph = std::move(std::get<GraphFile<G>>(*file).graph);
  if (near_optimum) {
    FullSolveOptions options;
    options.engine = Engine::kBlock;
    const FullSolveReport report = SolveFull(options, &graph);
    if (!report.status.ok()) return report.status;
    std::mt19937_64 rng(1);
    std::uniform_real_distribution<double> uniform(-0.01, 0.01);
    for (int k = 0; k < static_cast<int>(graph.nodes().size()); ++k) {
      typename G::Tangent d;
      for (int c = 0; c < G::kDof; ++c) d(c) = uniform(rng);
      graph.node(k).pose = graph.nodes()[k].pose.Retract(d);
    }
  }
  return graph;
}

// A problem to solve again and again, with what its factors point to.
template <typename G>
struct Case {
  Status status;
  std::shared_ptr<const void> owner;
  Subproblem<G> problem;
  SubproblemOptions options;
};

// A window in the middle of a level.
template <typename G>
Case<G> MakeWindow(const std::string& graph_name, int l, int nodes) {
  static std::map<std::string, std::shared_ptr<Hierarchy<G>>> hierarchies;
  Case<G> result;
  std::shared_ptr<Hierarchy<G>>& hierarchy = hierarchies[graph_name];
  if (hierarchy == nullptr) {
    const Result<PoseGraph<G>> graph = MakeGraph<G>(graph_name, true);
    result.status = graph.status();
    if (!graph.ok()) return result;
    hierarchy = std::make_shared<Hierarchy<G>>(MakeHierarchy(*graph, HierarchyOptions()));
  }
  Window<G> window;
  const auto middle = static_cast<Index>(hierarchy->level(0).nodes.size() / 2);
  const bool built =
      l < hierarchy->num_levels() &&
      window.Build(l, {hierarchy->Ancestor(middle, l)}, {nodes, 50 * nodes}, hierarchy.get());
  if (!built || window.subproblem().num_free != nodes) {
    result.status = Status(StatusCode::kInvalidArgument, "the level has no window of this size");
  }
  result.owner = hierarchy;
  result.problem = window.subproblem();
  return result;
}

// A whole graph at its chordal start, as SolveFull solves it.
template <typename G>
Case<G> MakeFull(const std::string& graph_name, int, int) {
  static std::map<std::string, Case<G>> cases;
  if (cases.count(graph_name) > 0) return cases[graph_name];
  Case<G> result;
  const Result<PoseGraph<G>> graph = MakeGraph<G>(graph_name, false);
  result.status = graph.status();
  if (!graph.ok()) return result;
  const auto whole = std::make_shared<FullProblem<G>>(
      *graph, GaugeNodes(*graph, FindComponents(*graph)),
      std::vector<bool>(graph->edges().size(), false), nullptr, ceres_costs::ErrorConvention::kG2o);
  const auto cost = [&](const std::vector<G>& poses) {
    whole->SetPoses(poses);
    return whole->Cost();
  };
  const Result<InitialGuess<G>> guess =
      MakeInitialGuess<G>(InitMethod::kChordal, *graph, cost, nullptr);
  result.status = guess.status();
  if (!guess.ok()) return result;
  whole->SetPoses(guess->poses);
  result.owner = whole;
  result.problem = *whole->subproblem();
  const FullSolveOptions full;
  result.options.max_iterations = full.max_iterations;
  result.options.function_tolerance = full.function_tolerance;
  result.options.initial_trust_region_radius = full.initial_trust_region_radius;
  return cases[graph_name] = result;
}

template <typename G>
using MakeCase = Case<G> (*)(const std::string& graph, int level, int nodes);

// What names a problem.
struct Name {
  std::string graph;
  int level = 0;
  int nodes = 0;
};

}  // namespace hpgo
