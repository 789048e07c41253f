// Incremental results against full optimization of the same graph.

#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/replay.h"
#include "test/optimizer/oracle.h"

namespace hpgo {
namespace {

template <typename G>
PoseGraph<G> World(hpgo::World world, int nodes, std::uint64_t seed = 1) {
  GenerateOptions options;
  options.world = world;
  options.nodes = nodes;
  options.seed = seed;
  Result<SyntheticGraph<G>> graph = GenerateGraph<G>(options);
  EXPECT_TRUE(graph.ok()) << graph.status().ToString();
  return std::move(graph->graph);
}

// The gap with a floor for graphs whose optimum is nearly zero.
template <typename G>
double BoundedGap(const Optimizer<G>& optimizer) {
  const double optimum = OptimumFrom(optimizer).cost;
  return (optimizer.Cost() - optimum) / (optimum + 1e-3 * (1. + optimizer.num_edges()));
}

template <typename G>
class RegressionTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(RegressionTest, Groups);

TYPED_TEST(RegressionTest, SmallGraphsAreNearTheOptimumAfterEveryUpdate) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 200);
  OptimizerOptions options;
  options.max_top_nodes = 20;  // several levels
  options.window_nodes = 40;
  Optimizer<TypeParam> optimizer(options);
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
    ASSERT_LT(BoundedGap(optimizer), 0.05) << "after node " << step.node;
  }
  EXPECT_GE(optimizer.num_levels(), 3);
  const UpdateReport refined = optimizer.Refine();
  EXPECT_TRUE(refined.at_rest);
  EXPECT_LT(Gap(optimizer), 1e-4);
  EXPECT_LT(LargestRelativeDifference(optimizer.ToGraph(), OptimumFrom(optimizer).graph), 1e-2);
}

TYPED_TEST(RegressionTest, LargerGraphsAreNearTheOptimumAtCheckpoints) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 1600);
  for (const Engine engine : {Engine::kBlock, Engine::kCeres}) {
    OptimizerOptions options;
    options.engine = engine;
    Optimizer<TypeParam> optimizer(options);
    int count = 0;
    for (const ReplayStep& step : ReplaySteps(graph)) {
      ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
      ASSERT_TRUE(optimizer.Update().status.ok());
      if (++count % 400 != 0) continue;
      EXPECT_LT(Gap(optimizer), 1e-3) << "at " << count;
    }
  }
}

TYPED_TEST(RegressionTest, EveryPresetKeepsAUsableEstimate) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 600);
  const std::vector<std::pair<std::string, double>> bounds = {
      {"accurate", 0.01}, {"fast", 0.05}, {"eager", 0.05}, {"paper", 1e-3}};
  for (const auto& [preset, bound] : bounds) {
    OptimizerOptions options = *OptimizerOptions::FromName(preset);
    options.max_top_nodes = 50;  // several levels
    Optimizer<TypeParam> optimizer(options);
    for (const ReplayStep& step : ReplaySteps(graph)) {
      ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
      ASSERT_TRUE(optimizer.Update().status.ok());
    }
    EXPECT_LT(BoundedGap(optimizer), bound) << preset;
  }
}

TYPED_TEST(RegressionTest, FullModeIsTheFullOptimum) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 150);
  OptimizerOptions options;
  options.mode = Mode::kFull;
  Optimizer<TypeParam> optimizer(options);
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    optimizer.Update();
  }
  EXPECT_LT(BoundedGap(optimizer), 1e-6);
}

TYPED_TEST(RegressionTest, EdgesBetweenOldNodesMayArriveLate) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 500);
  Optimizer<TypeParam> optimizer;
  std::vector<int> late;
  for (ReplayStep step : ReplaySteps(graph)) {
    late.insert(late.end(), step.edges.begin() + step.num_odometry, step.edges.end());
    step.edges.resize(step.num_odometry);
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    optimizer.Update();
  }
  ASSERT_GT(late.size(), 100u);
  for (const int k : late) {
    const GraphEdge<TypeParam>& edge = graph.edges()[k];
    ASSERT_TRUE(optimizer
                    .AddEdge(graph.nodes()[edge.i].id, graph.nodes()[edge.j].id, edge.measurement,
                             edge.information)
                    .ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  EXPECT_LT(Gap(optimizer), 0.01);
  optimizer.Refine();
  EXPECT_LT(Gap(optimizer), 1e-4);
}

TYPED_TEST(RegressionTest, ComponentsMayBeJoinedLater) {
  // Two sessions of one world, the second in a frame of its own.
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 300);
  typename TypeParam::Tangent d;
  d.setConstant(1.5);
  const TypeParam offset = TypeParam::Exp(d);
  Optimizer<TypeParam> optimizer;
  constexpr NodeId kSecond = 1000;
  for (const NodeId session : {NodeId{0}, kSecond}) {
    for (const auto& node : graph.nodes()) {
      const TypeParam pose = session == 0 ? node.pose : offset * node.pose;
      ASSERT_TRUE(optimizer.AddNode(session + node.id, pose).ok());
    }
    for (const auto& edge : graph.edges()) {
      ASSERT_TRUE(optimizer
                      .AddEdge(session + graph.nodes()[edge.i].id,
                               session + graph.nodes()[edge.j].id, edge.measurement,
                               edge.information)
                      .ok());
    }
    optimizer.Refine();
  }
  const double apart = optimizer.Cost();
  ASSERT_TRUE(optimizer
                  .AddEdge(graph.nodes()[10].id, kSecond + graph.nodes()[10].id, TypeParam(),
                           TypeParam::Matrix::Identity() * 100)
                  .ok());
  ASSERT_TRUE(optimizer.Update().status.ok());
  // The younger component has moved as a whole: the one edge costs nothing.
  EXPECT_NEAR(optimizer.Cost(), apart, 1e-6 * apart);
  for (const int k : {50, 150, 250}) {
    const TypeParam T = optimizer.GetPose(graph.nodes()[k].id)
                            ->Between(*optimizer.GetPose(kSecond + graph.nodes()[k].id));
    EXPECT_LT(TypeParam().LocalCoordinates(T).norm(), 0.1) << k;
  }
  optimizer.Refine();
  EXPECT_LT(Gap(optimizer), 1e-4);
}

TYPED_TEST(RegressionTest, SeveralEdgesMayConnectTheSameNodes) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 200);
  Optimizer<TypeParam> optimizer;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    for (const int k : step.edges) {
      const GraphEdge<TypeParam>& edge = graph.edges()[k];
      typename TypeParam::Tangent d;
      d.setConstant(0.01);
      ASSERT_TRUE(optimizer
                      .AddEdge(graph.nodes()[edge.j].id, graph.nodes()[edge.i].id,
                               edge.measurement.Inverse().Retract(d), edge.information)
                      .ok());
    }
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  EXPECT_EQ(optimizer.num_edges(), 2 * graph.edges().size());
  optimizer.Refine();
  EXPECT_LT(Gap(optimizer), 1e-4);
}

TYPED_TEST(RegressionTest, AWholeGraphMayBeAddedAtOnce) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 400);
  Optimizer<TypeParam> optimizer;
  PoseGraph<TypeParam> solved = graph;
  ASSERT_TRUE(SolveFull(FullSolveOptions(), &solved).status.ok());
  ASSERT_TRUE(optimizer.AddGraph(solved).ok());
  optimizer.Update();
  EXPECT_LT(Gap(optimizer), 1e-6);
}

// Under a time limit the windows are as large as it allows.
// Its work is counted in passes over the graph that it has taken in, not over what was there
// before.
TYPED_TEST(RegressionTest, AWholeGraphIsRefinedByWindows) {
  OptimizerOptions options;
  options.max_top_nodes = 20;
  options.window_nodes = 20;
  Optimizer<TypeParam> optimizer(options);
  ASSERT_TRUE(optimizer.AddGraph(World<TypeParam>(hpgo::World::kManhattan, 300)).ok());
  const UpdateReport report = optimizer.Refine();
  EXPECT_TRUE(report.at_rest);
  EXPECT_GT(report.examined_edges, static_cast<int>(optimizer.num_edges()));
  EXPECT_LT(BoundedGap(optimizer), 1e-4);
}

TYPED_TEST(RegressionTest, UpdatesThatAreGivenTimeUseIt) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 1000);
  Optimizer<TypeParam> optimizer;
  UpdateLimits limits;
  limits.max_seconds = 0.02;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    if (step.node % 50 != 0) continue;
    ASSERT_TRUE(optimizer.Update(limits).status.ok());
  }
  UpdateReport report;
  int updates = 0;
  do {
    report = optimizer.Update(limits);
    ASSERT_TRUE(report.status.ok());
  } while (!report.at_rest && ++updates < 100);
  EXPECT_TRUE(report.at_rest);
  EXPECT_LT(Gap(optimizer), 1e-3);
}

TYPED_TEST(RegressionTest, WindowsMayBeAsLargeAsTheMap) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 300);
  OptimizerOptions options;
  options.window_nodes = options.window_edges = std::numeric_limits<int>::max();
  Optimizer<TypeParam> optimizer(options);
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  EXPECT_TRUE(optimizer.Refine().at_rest);
  EXPECT_LT(Gap(optimizer), 1e-6);
  EXPECT_FALSE(optimizer.Optimize(Mode::kTop).at_rest) << "nobody has looked below";
}

TYPED_TEST(RegressionTest, TheSameCallsGiveTheSameBits) {
  const PoseGraph<TypeParam> graph = World<TypeParam>(hpgo::World::kManhattan, 300);
  PoseGraph<TypeParam> results[2];
  for (PoseGraph<TypeParam>& result : results) {
    Optimizer<TypeParam> optimizer;
    for (const ReplayStep& step : ReplaySteps(graph)) {
      ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
      optimizer.Update();
    }
    result = optimizer.ToGraph();
  }
  for (std::size_t k = 0; k < results[0].nodes().size(); ++k) {
    for (int p = 0; p < TypeParam::kParams; ++p) {
      ASSERT_EQ(results[0].nodes()[k].pose.data()[p], results[1].nodes()[k].pose.data()[p]);
    }
  }
}

}  // namespace
}  // namespace hpgo
