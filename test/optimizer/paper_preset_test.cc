// The paper's scheme: condensed edges, the whole top, a window at the newest node.

#include <cmath>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/replay.h"
#include "test/optimizer/oracle.h"

namespace hpgo {
namespace {

template <typename G>
class PaperPresetTest : public testing::Test {
 protected:
  // With windows so small that the top alone carries what is far from the newest node.
  static OptimizerOptions SmallWindows(int max_top_nodes) {
    OptimizerOptions options = OptimizerOptions::Paper();
    options.max_top_nodes = max_top_nodes;
    options.window_nodes = 10;
    return options;
  }
  static PoseGraph<G> Manhattan(int nodes) {
    GenerateOptions options;
    options.world = World::kManhattan;
    options.nodes = nodes;
    Result<SyntheticGraph<G>> graph = GenerateGraph<G>(options);
    EXPECT_TRUE(graph.ok()) << graph.status().ToString();
    return std::move(graph->graph);
  }
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(PaperPresetTest, Groups);

TYPED_TEST(PaperPresetTest, ANewLevelMadeAtRestLeavesTheEstimateAtRest) {
  constexpr int kNodes = 150;
  const PoseGraph<TypeParam> graph = this->Manhattan(kNodes);
  Optimizer<TypeParam> optimizer(this->SmallWindows(kNodes));
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  ASSERT_EQ(optimizer.num_levels(), 1);
  ASSERT_LT(std::abs(Gap(optimizer)), 1e-7);
  // One node too many for the top, where its only edge wants it.
  const GraphEdge<TypeParam>& edge = graph.edges().front();
  const NodeId last = graph.nodes().back().id;
  const TypeParam T_world_new = *optimizer.GetPose(last) * edge.measurement;
  ASSERT_TRUE(optimizer.AddNode(last + 1, T_world_new).ok());
  ASSERT_TRUE(optimizer.AddEdge(last, last + 1, edge.measurement, edge.information).ok());
  ASSERT_TRUE(optimizer.Update().status.ok());
  ASSERT_EQ(optimizer.num_levels(), 2);
  EXPECT_LT(Gap(optimizer), 1e-3);
}

// In its one window at the newest node and in the top.
TYPED_TEST(PaperPresetTest, AClosureThatComesWithANewLevelIsNotLost) {
  constexpr int kNodes = 150;
  const PoseGraph<TypeParam> graph = this->Manhattan(kNodes);
  Optimizer<TypeParam> optimizer(this->SmallWindows(kNodes));
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<TypeParam>(graph, step, nullptr, &optimizer).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  const GraphEdge<TypeParam>& edge = graph.edges().front();
  const NodeId first = graph.nodes().front().id, last = graph.nodes().back().id;
  const TypeParam T_last_new = edge.measurement;
  const TypeParam T_first_new =
      optimizer.GetPose(first)->Between(*optimizer.GetPose(last)) * T_last_new;
  // Wants the new node elsewhere by some tenths of a metre.
  typename TypeParam::Tangent d = TypeParam::Tangent::Zero();
  d(0) = 0.5;
  const auto information = (10 * edge.information).eval();
  ASSERT_TRUE(optimizer.AddNode(last + 1, *optimizer.GetPose(last) * T_last_new).ok());
  ASSERT_TRUE(optimizer.AddEdge(last, last + 1, T_last_new, edge.information).ok());
  ASSERT_TRUE(
      optimizer.AddEdge(first, last + 1, T_first_new * TypeParam::Exp(d), information).ok());
  const double before = optimizer.Cost();
  const double optimum = OptimumFrom(optimizer).cost;
  ASSERT_TRUE(optimizer.Update().status.ok());
  ASSERT_EQ(optimizer.num_levels(), 2);
  EXPECT_LT(optimizer.Cost() - optimum, 0.1 * (before - optimum));
}

// The newest node may hang free, or be inside a chain.
TYPED_TEST(PaperPresetTest, ItsScheduleDoesWithChains) {
  using G = TypeParam;
  OptimizerOptions options;
  options.schedule = Schedule::kNewestNode;
  options.max_top_nodes = 5;
  Optimizer<G> optimizer(options);
  const PoseGraph<G> graph = this->Manhattan(100);
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<G>(graph, step, nullptr, &optimizer).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  ASSERT_TRUE(optimizer.AddNode(1000, G()).ok());  // without any edge
  ASSERT_TRUE(optimizer.Update().status.ok());
  EXPECT_LT(Gap(optimizer), 0.2);
}

}  // namespace
}  // namespace hpgo
