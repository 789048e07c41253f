// Clients that bring thousands of nodes between two updates, where dead reckoning has drifted by
// more than a linearization reaches. Chains that would have to bend that far, windows and rigid
// groups make knots of them.

#include <string>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/replay.h"
#include "hpgo/solve/full_solve.h"

namespace hpgo {
namespace {

constexpr int kNodes = 12'000;

PoseGraph<SE3> DriftingCity() {
  GenerateOptions generate;
  generate.world = World::kCity;
  generate.nodes = kNodes;
  generate.noise_rotation = 0.02;
  return GenerateGraph<SE3>(generate)->graph;
}

double OptimumOf(PoseGraph<SE3> graph, InitMethod init) {
  FullSolveOptions options;
  options.init = init;
  const FullSolveReport report = SolveFull(options, &graph);
  EXPECT_TRUE(report.converged);
  return report.cost_after;
}

TEST(FarOffTest, ThousandsOfNodesAtOnceAreTakenIn) {
  const PoseGraph<SE3> graph = DriftingCity();
  const double optimum = OptimumOf(graph, InitMethod::kAuto);
  for (const bool converge : {false, true}) {
    SCOPED_TRACE(converge ? "Converge" : "Update");
    Optimizer<SE3> optimizer;
    for (const ReplayStep& step : ReplaySteps(graph)) {
      ASSERT_TRUE(ApplyStep<SE3>(graph, step, nullptr, &optimizer).ok());
      const std::size_t nodes = optimizer.num_nodes();
      if (nodes != 500 && nodes != 5200 && nodes != 8600 && nodes != kNodes) continue;
      UpdateReport report = converge ? optimizer.Converge() : optimizer.Update();
      ASSERT_TRUE(report.status.ok());
    }
    EXPECT_LE(optimizer.Cost(), (converge ? 1.000001 : 1.01) * optimum);
    EXPECT_TRUE(optimizer.Refine().at_rest);
    EXPECT_LE(optimizer.Cost(), 1.000001 * optimum);
  }
}

// All of them in slices of time that are far too short: the end is that of a full optimization from
// the same start, dead reckoning, a minimum above the lowest.
TEST(FarOffTest, SlicesOfRefineEndWhereFullOptimizationDoes) {
  const PoseGraph<SE3> graph = DriftingCity();
  Optimizer<SE3> optimizer;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<SE3>(graph, step, nullptr, &optimizer).ok());
  }
  UpdateLimits limits;
  limits.max_seconds = 0.01;
  UpdateReport report;
  for (int slice = 0; slice < 500 && !report.at_rest; ++slice) {
    report = optimizer.Refine(limits);
    ASSERT_TRUE(report.status.ok());
  }
  EXPECT_TRUE(report.at_rest);
  EXPECT_LE(optimizer.Cost(), 1.000001 * OptimumOf(graph, InitMethod::kOdometry));
}

}  // namespace
}  // namespace hpgo
