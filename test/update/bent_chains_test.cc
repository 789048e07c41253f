// Odometry that is stiff in its distances and soft in its turns, with wrong closures: chains are
// bent far beyond their linearizations, and many cannot follow their ends. Clients update rarely.

#include <memory>
#include <string>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/replay.h"

namespace hpgo {
namespace {

template <typename G>
class BentChainsTest : public testing::Test {
 protected:
  static SyntheticGraph<G> Generate(World world, std::uint64_t seed, double noise_rotation) {
    GenerateOptions generate;
    generate.world = world;
    generate.nodes = 300;
    generate.seed = seed;
    generate.noise_rotation = noise_rotation;
    generate.noise_translation = 0.02 * noise_rotation;
    generate.outliers = 0.25;
    return *GenerateGraph<G>(generate);
  }

  // check(before, report, after): the costs around updates without changes, up to 40 after every 20
  // nodes.
  template <typename Check>
  static void Drive(World world, std::uint64_t seed, double noise_rotation,
                    const std::shared_ptr<const ceres::LossFunction>& loss, Check&& check) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", " + std::to_string(noise_rotation) + " rad");
    const SyntheticGraph<G> synthetic = Generate(world, seed, noise_rotation);
    Optimizer<G> optimizer;
    for (const ReplayStep& step : ReplaySteps(synthetic.graph)) {
      ASSERT_TRUE(ApplyStep<G>(synthetic.graph, step, loss, &optimizer).ok());
      if (optimizer.num_nodes() % 20 != 0) continue;
      UpdateReport report = optimizer.Update();
      double before = optimizer.Cost();
      for (int k = 0; k < 40 && !report.at_rest; ++k) {
        report = optimizer.Update();
        const double after = optimizer.Cost();
        SCOPED_TRACE("at node " + std::to_string(optimizer.num_nodes()) + ", update " +
                     std::to_string(k));
        check(before, report, after);
        before = after;
      }
    }
  }
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(BentChainsTest, Groups);

// Nor where a chain is cut because it could not follow.
TYPED_TEST(BentChainsTest, AnUpdateWithoutChangesDoesNotRaiseTheCost) {
  for (const std::uint64_t seed : {11, 13, 15}) {
    for (const double noise : {0.05, 0.15}) {
      this->Drive(World::kCity, seed, noise, nullptr,
                  [](double before, const UpdateReport&, double after) {
                    EXPECT_LE(after, before * (1 + 1e-5));
                  });
    }
  }
}

// A step after which its chains cost more is made shorter, not tried again for ever.
TYPED_TEST(BentChainsTest, AWindowThatIsSolvedGains) {
  const std::shared_ptr<const ceres::LossFunction> loss(new ceres::HuberLoss(0.6));
  for (const std::uint64_t seed : {2, 8, 31, 44}) {
    this->Drive(World::kManhattan, seed, 0.15, loss,
                [](double before, const UpdateReport& report, double after) {
                  if (report.at_rest || report.windows + report.top_solves == 0) return;
                  EXPECT_LT(after, before);
                });
  }
}

// Chains that could not follow are cut before it is at rest.
TYPED_TEST(BentChainsTest, ConvergeRestsAtAnOptimum) {
  for (const std::uint64_t seed : {11, 13, 15}) {
    SCOPED_TRACE(seed);
    const SyntheticGraph<TypeParam> synthetic = this->Generate(World::kCity, seed, 0.05);
    Optimizer<TypeParam> optimizer;
    for (const ReplayStep& step : ReplaySteps(synthetic.graph)) {
      ASSERT_TRUE(ApplyStep<TypeParam>(synthetic.graph, step, nullptr, &optimizer).ok());
      if (optimizer.num_nodes() % 60 != 0) continue;
      if (!optimizer.Converge().at_rest) continue;
      const auto& edges = optimizer.hierarchy().level(0).edges;
      for (Index e = 0; e < static_cast<Index>(edges.size()); ++e) {
        EXPECT_FALSE(edges[e].alive && edges[e].lags) << "at node " << optimizer.num_nodes();
      }
    }
  }
}

}  // namespace
}  // namespace hpgo
