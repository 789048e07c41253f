// ceres_bench [nodes [growing]]: hpgo::Solve against ceres::Solve on the problems of mappers with
// their own (automatically differentiated) costs: CPU time from the call to the same cost,
// recognition included. With `growing`, hpgo::ProblemSolver on problems that grow node by node,
// against ceres::Solve at closures. The tables of hpgo/ceres/README.md. Worlds made up have `nodes`
// nodes (10000).
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "ceres/solver.h"
#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/problem_solver.h"
#include "hpgo/ceres/problem_view.h"
#include "hpgo/ceres/solve.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/replay.h"
#include "test/bench/measure.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// When which cost was reached.
class Trace final : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (iteration.step_is_successful) points_.emplace_back(CpuSeconds() - begin_, iteration.cost);
    return ceres::SOLVER_CONTINUE;
  }
  double BestCost() const {
    double best = points_.front().second;
    for (const auto& [time, cost] : points_) best = std::min(best, cost);
    return best;
  }
  // Negative if never.
  double TimeTo(double target) const {
    for (const auto& [time, cost] : points_) {
      if (cost <= target) return time;
    }
    return -1;
  }

 private:
  const double begin_ = CpuSeconds();
  std::vector<std::pair<double, double>> points_;
};

template <typename Mapper, typename G>
void Row(const std::string& name, Mapper mapper, const PoseGraph<G>& graph) {
  const auto run = [&](bool ours, ceres::Solver::Summary* summary) {
    const auto problem = MakeMapperProblem(mapper, graph);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 200;
    options.function_tolerance = 1e-8;
    options.logging_type = ceres::SILENT;
    Trace trace;
    options.callbacks.push_back(&trace);
    if (ours) {
      hpgo::Solve(options, problem->problem.get(), summary);
    } else {
      ceres::Solve(options, problem->problem.get(), summary);
    }
    return trace;
  };
  ceres::Solver::Summary ours, theirs;
  const Trace our_trace = run(true, &ours), their_trace = run(false, &theirs);
  const double target = std::max(our_trace.BestCost(), their_trace.BestCost()) * (1 + 1e-6);
  const double our_time = our_trace.TimeTo(target), their_time = their_trace.TimeTo(target);

  const auto problem = MakeMapperProblem(mapper, graph);
  const double begin = CpuSeconds();
  const ProblemView view(*problem->problem);
  PoseBlocks poses;
  std::string reason;
  if (!FindPoseBlocks(view, {}, &poses, &reason)) std::printf("%s\n", reason.c_str());
  const double recognition = CpuSeconds() - begin;
  std::printf("| %s | %s | %.6g / %zu it | %.6g / %zu it | %.1f | %.1f | %.1f | %.1f %% |\n",
              name.c_str(), MapperName(mapper), their_trace.BestCost(),
              theirs.iterations.size() - 1, our_trace.BestCost(), ours.iterations.size() - 1,
              1e3 * their_time, 1e3 * our_time, their_time / our_time,
              100 * recognition / our_time);
  std::fflush(stdout);
}

// The costs of a mapper's problem added node by node to one that persists, its poses in the storage
// of G; Update at every node that closes a loop, through the calls that need no looking.
template <typename G, typename Mapper>
void Grow(const std::string& name, Mapper mapper, const PoseGraph<G>& graph) {
  constexpr int kSamples = 20;
  if (graph.nodes().empty()) return;
  const auto made = MakeMapperProblem(mapper, graph);
  std::vector<ceres::ResidualBlockId> ids;
  made->problem->GetResidualBlocks(&ids);
  const std::vector<ReplayStep> steps = ReplaySteps(graph);
  int closing_nodes = 0;
  for (const ReplayStep& step : steps) closing_nodes += step.closes_loop();

  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  ProblemSolverOptions options;
  options.watch = false;
  ProblemSolver solver(&problem, options);
  int closing = 0, sample = 0;
  std::vector<double> ours, theirs, gaps;
  for (int n = 1; n < static_cast<int>(graph.nodes().size()); ++n) {
    for (const int e : steps[n].edges) {
      const GraphEdge<G>& edge = graph.edges()[e];
      double* blocks[2] = {made->Block(edge.i, 0), made->Block(edge.j, 0)};
      if (edge.i == n - 1 && edge.j == n) {
        const G pose = G(blocks[0]) * edge.measurement;
        std::copy_n(pose.data(), G::kParams, blocks[1]);
      }
      solver.AddResidualBlock(
          const_cast<ceres::CostFunction*>(made->problem->GetCostFunctionForResidualBlock(ids[e])),
          const_cast<ceres::LossFunction*>(made->problem->GetLossFunctionForResidualBlock(ids[e])),
          blocks[0], blocks[1]);
      for (double* block : blocks) {
        if (made->manifolds[0]->AmbientSize() == G::kParams) {
          problem.SetManifold(block, made->manifolds[0].get());
        }
      }
    }
    if (n == 1) solver.SetParameterBlockConstant(made->Block(0, 0));
    const double begin = CpuSeconds();
    solver.Update();
    const double seconds = CpuSeconds() - begin;
    if (!steps[n].closes_loop()) continue;
    ours.push_back(1e3 * seconds);
    if (++closing * kSamples < (sample + 1) * closing_nodes) continue;
    ++sample;
    double after = 0;
    problem.Evaluate({}, &after, nullptr, nullptr, nullptr);
    const std::vector<std::vector<double>> values = made->storage;
    ceres::Solver::Options solver_options;
    solver_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver_options.logging_type = ceres::SILENT;
    solver_options.max_num_iterations = 100;
    ceres::Solver::Summary summary;
    const double ceres_begin = CpuSeconds();
    ceres::Solve(solver_options, &problem, &summary);
    theirs.push_back(1e3 * (CpuSeconds() - ceres_begin));
    solver_options.function_tolerance = 1e-10;
    ceres::Solve(solver_options, &problem, &summary);
    gaps.push_back(100 * (after / summary.final_cost - 1));
    for (std::size_t p = 0; p < values.size(); ++p) {
      std::copy(values[p].begin(), values[p].end(), made->storage[p].begin());
    }
  }
  std::printf("| %s | %s | %zu | %.2f / %.2f | %.1f / %.1f | %.3f / %.3f | %s |\n", name.c_str(),
              MapperName(mapper), graph.nodes().size(), Quantile(ours, 0.5), Quantile(ours, 0.99),
              Quantile(theirs, 0.5), Quantile(theirs, 1), Quantile(gaps, 0.5), Quantile(gaps, 1),
              solver.why_not_kept().c_str());
  std::fflush(stdout);
}

template <typename G>
PoseGraph<G> Read(const std::string& name) {
  Result<AnyGraphFile> file =
      ReadG2o(std::string(HPGO_SHARED_DATA_DIR) + "/" + name, ReadOptions(), nullptr);
  if (!file.ok()) return {};
  return std::get<GraphFile<G>>(*file).graph;
}

template <typename G>
PoseGraph<G> Make(World world, int nodes) {
  GenerateOptions options;
  options.world = world;
  options.nodes = nodes;
  return GenerateGraph<G>(options)->graph;
}

void Run(int nodes) {
  std::printf(
      "| graph | as built by | ceres::Solve | hpgo::Solve | ceres ms | hpgo ms | times | "
      "recognition |\n|---|---|---|---|---|---|---|---|\n");
  for (const auto& [name, file] :
       {std::pair("M3500", "g2o/M3500.g2o"), std::pair("KITTI 00", "kitti/graphs/kitti_00.g2o")}) {
    const auto graph = Read<SE2>(file);
    if (graph.nodes().empty()) continue;
    for (const Mapper2d mapper : {Mapper2d::kSlamToolbox, Mapper2d::kCartographer}) {
      Row(name, mapper, graph);
    }
  }
  const auto each = [](const std::string& name, const PoseGraph<SE3>& graph) {
    if (graph.nodes().empty()) return;
    for (const Mapper3d mapper : {Mapper3d::kCeresExample, Mapper3d::kFuse, Mapper3d::kOv2slam}) {
      Row(name, mapper, graph);
    }
  };
  each("sphere2500", Read<SE3>("g2o/sphere2500.g2o"));
  each("torus3D", Read<SE3>("g2o/torus3D.g2o"));
  each("manhattan", Make<SE3>(World::kManhattan, nodes));
  Row("city", Mapper2d::kSlamToolbox, Make<SE2>(World::kCity, nodes));
  each("city", Make<SE3>(World::kCity, nodes));
  Row("city", Mapper3d::kVins4, Make<SE3>(World::kCity, nodes));
}

void RunGrowing(int nodes) {
  std::printf(
      "| graph | as built by | nodes | Update ms p50 / p99 | ceres ms p50 / max | gap %% right "
      "after, "
      "p50 / max | |\n|---|---|---|---|---|---|---|\n");
  Grow("M3500", Mapper2d::kCartographer, Read<SE2>("g2o/M3500.g2o"));
  Grow("sphere2500", Mapper3d::kOkvis, Read<SE3>("g2o/sphere2500.g2o"));
  for (const int n : {nodes / 10, nodes / 3, nodes}) {
    Grow("city", Mapper2d::kCartographer, Make<SE2>(World::kCity, n));
  }
  Grow("city, 3D", Mapper3d::kOkvis, Make<SE3>(World::kCity, nodes));
}

}  // namespace
}  // namespace hpgo

int main(int argc, char** argv) {
  const int nodes = argc > 1 ? std::atoi(argv[1]) : 10000;
  if (argc > 2 && std::string(argv[2]) == "growing") {
    hpgo::RunGrowing(nodes);
  } else {
    hpgo::Run(nodes);
  }
}
