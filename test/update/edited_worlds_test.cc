// Measurements that turn out to be far off, long after they came: chains are bent as far as they
// go, cut and joined. An update without changes does not raise the cost then either.

#include <random>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/replay.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

// The largest rise, as a share of the cost, of the updates after a few measurements of a city were
// replaced by random ones.
template <typename G>
double LargestRise(std::uint64_t seed) {
  GenerateOptions generate;
  generate.world = World::kCity;
  generate.nodes = 300;
  generate.seed = seed;
  generate.noise_rotation = 0.15;
  generate.noise_translation = 0.03;
  const SyntheticGraph<G> synthetic = *GenerateGraph<G>(generate);
  Optimizer<G> optimizer;
  for (const ReplayStep& step : ReplaySteps(synthetic.graph)) {
    EXPECT_TRUE(ApplyStep<G>(synthetic.graph, step, nullptr, &optimizer).ok());
    optimizer.Update();
  }
  const std::vector<EdgeError> edges = optimizer.EdgeErrors();
  const typename G::Matrix information = synthetic.graph.edges().front().information;
  std::mt19937_64 rng(seed);
  double largest = 0;
  for (int round = 0; round < 3; ++round) {
    for (int k = 0; k < 4; ++k) {
      EXPECT_TRUE(
          optimizer
              .UpdateEdge(edges[rng() % edges.size()].id, RandomPose<G>(&rng, 5, 1), information)
              .ok());
    }
    optimizer.Update();
    double before = optimizer.Cost();
    for (int k = 0; k < 8; ++k) {
      optimizer.Update();
      const double after = optimizer.Cost();
      largest = std::max(largest, after / before - 1);
      before = after;
    }
  }
  return largest;
}

TEST(EditedWorldsTest, AnUpdateWithoutChangesDoesNotRaiseTheCost) {
  for (const std::uint64_t seed : {8, 17, 38, 58}) EXPECT_LT(LargestRise<SE2>(seed), 1e-4) << seed;
  for (const std::uint64_t seed : {7, 8, 26}) EXPECT_LT(LargestRise<SE3>(seed), 1e-4) << seed;
}

}  // namespace
}  // namespace hpgo
