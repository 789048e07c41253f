// ceres_bench [nodes]: hpgo::Solve against ceres::Solve on the problems of mappers with their own
// (automatically differentiated) costs: CPU time from the call to the same cost, recognition
// included. The table of hpgo/ceres/README.md. Worlds made up have `nodes` nodes (10000).
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "ceres/solver.h"
#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/problem_view.h"
#include "hpgo/ceres/solve.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/g2o_reader.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

double CpuSeconds() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

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

}  // namespace
}  // namespace hpgo

int main(int argc, char** argv) { hpgo::Run(argc > 1 ? std::atoi(argv[1]) : 10000); }
