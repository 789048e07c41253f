// Calls that have no time at all: each makes a little progress whatever the machine, so that calls
// one after the other end where one without a limit does.

#include <memory>

#include "ceres/loss_function.h"
#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "test/optimizer/bring_all.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

constexpr double kNoTime = 1e-9;  // s
constexpr int kManyCalls = 2000;

template <typename G>
class ShortTimeTest : public testing::Test {
 protected:
  static PoseGraph<G> Graph(World world, int nodes) {
    GenerateOptions generate;
    generate.world = world;
    generate.nodes = nodes;
    return GenerateGraph<G>(generate)->graph;
  }
  // Of four nodes that do not fit.
  static void Ring(const std::shared_ptr<const ceres::LossFunction>& loss,
                   Optimizer<G>* optimizer) {
    for (int k = 0; k < 4; ++k) ASSERT_TRUE(optimizer->AddNode(k, G()).ok());
    const G step = G::Exp(G::Tangent::Unit(0));
    for (int k = 0; k < 4; ++k) {
      const auto information = G::Matrix::Identity();
      ASSERT_TRUE(optimizer->AddEdge(k, (k + 1) % 4, step, information, loss).ok());
    }
  }
  // Until `call` is at rest, how often it was made.
  template <typename Call>
  static int CallsToRest(const Call& call) {
    UpdateLimits limits;
    limits.max_cpu_seconds = kNoTime;
    int calls = 0;
    UpdateReport report;
    while (!report.at_rest && calls < kManyCalls) {
      ++calls;
      report = call(limits);
      EXPECT_TRUE(report.status.ok()) << report.status.ToString();
    }
    EXPECT_TRUE(report.at_rest);
    return calls;
  }
};

using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(ShortTimeTest, Groups);

TYPED_TEST(ShortTimeTest, RefineAndConvergeGetToTheOptimum) {
  for (const Engine engine : {Engine::kBlock, Engine::kCeres}) {
    for (const World world : {World::kManhattan, World::kCity}) {
      SCOPED_TRACE(testing::Message() << static_cast<int>(engine) << static_cast<int>(world));
      const PoseGraph<TypeParam> graph = this->Graph(world, 600);
      const double optimum = OptimumOf(graph);
      OptimizerOptions options;
      options.engine = engine;
      for (const bool converge : {false, true}) {
        Optimizer<TypeParam> optimizer(options);
        BringAll(graph, &optimizer);
        const int calls = this->CallsToRest([&](const UpdateLimits& limits) {
          return converge ? optimizer.Converge(limits) : optimizer.Refine(limits);
        });
        EXPECT_GT(calls, 3);
        EXPECT_LE(optimizer.Cost(), 1.00001 * optimum);
        const UpdateReport again = optimizer.Refine();
        EXPECT_TRUE(again.at_rest);
        EXPECT_EQ(again.examined_edges, 0);
      }
    }
  }
}

// An update in between has changed something, and may have left work to do.
TYPED_TEST(ShortTimeTest, WhatAnUpdateLeavesIsTakenUpAgain) {
  using G = TypeParam;
  const PoseGraph<G> graph = this->Graph(World::kManhattan, 300);
  for (const Schedule schedule : {Schedule::kStress, Schedule::kNewEdges}) {
    OptimizerOptions options;
    options.schedule = schedule;
    options.window_nodes = options.max_top_nodes = 10;
    Optimizer<G> optimizer(options);
    BringAll(graph, &optimizer);
    ASSERT_TRUE(optimizer.Converge().at_rest);
    const double optimum = optimizer.Cost();
    for (NodeId id = 0; id < 300; id += 10) {
      const G moved = optimizer.GetPose(id)->Retract(G::Tangent::Unit(0));
      ASSERT_TRUE(optimizer.SetPose(id, moved).ok());
    }
    UpdateLimits limits;
    limits.max_cpu_seconds = kNoTime;
    schedule == Schedule::kStress ? optimizer.Update(limits) : optimizer.Refine(limits);
    ASSERT_GT(optimizer.Cost(), 1.01 * optimum);
    EXPECT_TRUE(optimizer.Converge().at_rest);
    EXPECT_LE(optimizer.Cost(), 1.00001 * optimum);
  }
}

TYPED_TEST(ShortTimeTest, UpdatesComeToRest) {
  const PoseGraph<TypeParam> graph = this->Graph(World::kManhattan, 1000);
  Optimizer<TypeParam> optimizer;
  BringAll(graph, &optimizer);
  this->CallsToRest([&](const UpdateLimits& limits) { return optimizer.Update(limits); });
  EXPECT_LE(optimizer.Cost(), 1.01 * OptimumOf(graph));
}

// Their windows know no rest.
TYPED_TEST(ShortTimeTest, ConvergeGetsToTheOptimumUnderFixedSchedules) {
  const PoseGraph<TypeParam> graph = this->Graph(World::kManhattan, 300);
  for (const Schedule schedule : {Schedule::kNewEdges, Schedule::kNewestNode}) {
    OptimizerOptions options;
    options.schedule = schedule;
    Optimizer<TypeParam> optimizer(options);
    BringAll(graph, &optimizer);
    this->CallsToRest([&](const UpdateLimits& limits) { return optimizer.Converge(limits); });
    EXPECT_LE(optimizer.Cost(), 1.00001 * OptimumOf(graph));
  }
}

TYPED_TEST(ShortTimeTest, ConvergeRestsWhereNothingGains) {
  using G = TypeParam;
  int evaluations = 0;
  Optimizer<G> optimizer;
  this->Ring(std::make_shared<EverOther>(1.001, &evaluations), &optimizer);
  EXPECT_TRUE(optimizer.Converge().at_rest);
}

// What is left there is rounding, of which some is gained for ever.
TYPED_TEST(ShortTimeTest, ConvergeRestsWithoutNoise) {
  using G = TypeParam;
  GenerateOptions generate;
  generate.world = World::kManhattan;
  generate.noise_translation = generate.noise_rotation = 0;
  for (generate.seed = 1; generate.seed <= 20; ++generate.seed) {
    generate.nodes = 50 + 5 * static_cast<int>(generate.seed);
    const PoseGraph<G> graph = GenerateGraph<G>(generate)->graph;
    for (const Engine engine : {Engine::kBlock, Engine::kCeres}) {
      OptimizerOptions options;
      options.engine = engine;
      Optimizer<G> optimizer(options);
      BringAll(graph, &optimizer);
      ASSERT_TRUE(optimizer.SetPose(20, G()).ok());
      EXPECT_TRUE(optimizer.Converge().at_rest) << generate.seed;
    }
  }
}

}  // namespace
}  // namespace hpgo
