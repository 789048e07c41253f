// An update without changes does not end above the cost it began with under noise that is large:
// with 0.2 rad and 0.2 m an edge, chains bend further than their linearizations reach. Levels above
// may be a little stale where windows are small.

#include <algorithm>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/replay.h"

namespace hpgo {
namespace {

GenerateOptions Noisy(World world, int nodes, std::uint64_t seed, double rotation,
                      double translation, double outliers = 0) {
  GenerateOptions generate;
  generate.world = world;
  generate.nodes = nodes;
  generate.seed = seed;
  generate.noise_rotation = rotation;
  generate.noise_translation = translation;
  generate.outliers = outliers;
  return generate;
}

// With small windows, so that all kinds of them are met.
OptimizerOptions SmallWindows(OptimizerOptions options, int window_nodes, int max_windows) {
  options.max_top_nodes = 60;
  options.window_nodes = window_nodes;
  options.max_windows = max_windows;
  return options;
}

template <typename G>
void ExpectNoRise(const GenerateOptions& generate, const OptimizerOptions& options, int updates) {
  SCOPED_TRACE("seed " + std::to_string(generate.seed));
  const SyntheticGraph<G> synthetic = *GenerateGraph<G>(generate);
  Optimizer<G> optimizer(options);
  for (const ReplayStep& step : ReplaySteps(synthetic.graph)) {
    ASSERT_TRUE(ApplyStep<G>(synthetic.graph, step, nullptr, &optimizer).ok());
    optimizer.Update();
    if (!step.closes_loop() || optimizer.num_nodes() % 3 != 0) continue;
    double before = optimizer.Cost();
    for (int k = 0; k < updates; ++k) {
      const UpdateReport report = optimizer.Update();
      const double after = optimizer.Cost();
      ASSERT_LE(after, before * (1 + 1e-5) + 1e-12)
          << "at node " << optimizer.num_nodes() << ", update " << k << ": the report has "
          << report.cost_decrease;
      before = after;
    }
  }
}

template <typename G>
class RisingCostTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(RisingCostTest, Groups);

TYPED_TEST(RisingCostTest, AnUpdateWithoutChangesDoesNotRaiseIt) {
  for (const World world : {World::kCity, World::kManhattan}) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      for (const int max_windows : {3, 6}) {
        ExpectNoRise<TypeParam>(Noisy(world, 600, seed, 0.2, 0.2),
                                SmallWindows(OptimizerOptions(), 40, max_windows), 5);
      }
    }
  }
}

// Nor while wrong closures are taken in by degrees: the caller sees what they measure.
TYPED_TEST(RisingCostTest, NorDoesOneThatTakesInAClosureByDegrees) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    ExpectNoRise<TypeParam>(Noisy(World::kCity, 1000, seed, 0.03, 0.02, 0.3),
                            SmallWindows(OptimizerOptions(), 20, 3), 20);
  }
}

// Nor where coarse edges have long been merged elsewhere, and many are wrong.
TEST(RisingCostOfWrongClosuresTest, NorDoesOneBetweenManyWrongClosures) {
  for (const std::uint64_t seed : {13, 15, 26}) {
    ExpectNoRise<SE2>(Noisy(World::kManhattan, 500, seed, 0.3, 0.02, 0.05),
                      SmallWindows(OptimizerOptions(), 40, 3), 20);
  }
}

// Nor one of the paper's schedule, whose coarse edges hold measurements: at the optimum of a level
// the graph is not.
TEST(RisingCostOfPaperTest, NorDoesOneOfItsSchedule) {
  for (const World world : {World::kCity, World::kManhattan}) {
    for (const std::uint64_t seed : {1, 2}) {
      ExpectNoRise<SE2>(Noisy(world, 400, seed, 0.1, 0.05, 0.1),
                        SmallWindows(OptimizerOptions::Paper(), 40, 3), 3);
    }
  }
}

// Only what does not fit into a chain is cut out of it: not where a step that gains nothing any
// more loses the last digits.
TYPED_TEST(RisingCostTest, ChainsAreNotCutByRounding) {
  for (const double noise : {1e-6, 1e-3, 1e-2}) {
    GenerateOptions generate;
    generate.world = World::kCity;
    generate.nodes = 1500;
    generate.noise_rotation = generate.noise_translation = noise;
    const SyntheticGraph<TypeParam> synthetic = *GenerateGraph<TypeParam>(generate);
    Optimizer<TypeParam> optimizer;
    for (const ReplayStep& step : ReplaySteps(synthetic.graph)) {
      ASSERT_TRUE(ApplyStep<TypeParam>(synthetic.graph, step, nullptr, &optimizer).ok());
      optimizer.Update();
    }
    const Index kept = optimizer.hierarchy().level(0).num_nodes;
    EXPECT_TRUE(optimizer.Refine().at_rest);
    EXPECT_TRUE(optimizer.Optimize(Mode::kFull).status.ok());
    optimizer.Update();
    EXPECT_EQ(optimizer.hierarchy().level(0).num_nodes, kept) << noise;
  }
}

}  // namespace
}  // namespace hpgo
