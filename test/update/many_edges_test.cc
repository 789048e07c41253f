// Nodes with more edges than a window holds.

#include <random>

#include "gtest/gtest.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class ManyEdgesTest : public testing::Test {
 protected:
  G Measured(const G& T) { return T * RandomPose<G>(&rng_, 0.1, 0.05); }

  std::mt19937_64 rng_{5};
  typename G::Matrix information_ = 100 * G::Matrix::Identity();
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(ManyEdgesTest, Groups);

TYPED_TEST(ManyEdgesTest, TwoPosesMayBeMeasuredAgainAndAgain) {
  using G = TypeParam;
  OptimizerOptions options;
  Optimizer<G> optimizer(options);
  G step;
  step.translation()(0) = 1;
  ASSERT_TRUE(optimizer.AddNode(0, G()).ok());
  ASSERT_TRUE(optimizer.AddNode(1, step).ok());
  for (int k = 0; k < options.window_edges + 500; ++k) {
    ASSERT_TRUE(optimizer.AddEdge(0, 1, this->Measured(step), this->information_).ok());
  }
  optimizer.Update();
  EXPECT_LT(Gap(optimizer), 1e-6);
}

TYPED_TEST(ManyEdgesTest, AHubWithMoreEdgesThanAWindowMoves) {
  using G = TypeParam;
  OptimizerOptions options;
  options.window_edges = 50;
  options.max_top_nodes = 20;
  Optimizer<G> optimizer(options);
  const int spokes = 120;
  ASSERT_TRUE(optimizer.AddNode(0, G()).ok());
  std::vector<G> truth{G()};
  for (int k = 1; k <= spokes; ++k) {
    truth.push_back(RandomPose<G>(&this->rng_, 5, 1));
    ASSERT_TRUE(optimizer.AddNode(k, this->Measured(truth[k])).ok());
    ASSERT_TRUE(optimizer.AddEdge(0, k, this->Measured(truth[k]), this->information_).ok());
    if (k > 1) {
      const G Z = this->Measured(truth[k - 1].Between(truth[k]));
      ASSERT_TRUE(optimizer.AddEdge(k - 1, k, Z, this->information_).ok());
    }
  }
  ASSERT_TRUE(optimizer.SetFixed(spokes, true).ok());  // so that the hub itself has to move
  const UpdateReport report = optimizer.Refine();
  EXPECT_TRUE(report.at_rest);
  EXPECT_LT(Gap(optimizer), 1e-6);
}

// With all edges of the hub up for a look, the update would get to nothing else.
TYPED_TEST(ManyEdgesTest, ARemovalAtAHubIsSettledAtOnce) {
  using G = TypeParam;
  Optimizer<G> optimizer;
  const int spokes = 300;
  ASSERT_TRUE(optimizer.AddNode(0, G()).ok());
  G Z;
  Z.translation()(0) = 1;
  for (int k = 1; k <= spokes; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, Z).ok());
    ASSERT_TRUE(optimizer.AddEdge(0, k, Z, this->information_).ok());
    if (k > 1) {
      ASSERT_TRUE(optimizer.AddEdge(k - 1, k, G(), this->information_).ok());
    }
  }
  G off = Z;
  off.translation()(0) = 1.01;
  const EdgeId wrong = *optimizer.AddEdge(0, spokes / 2, off, this->information_);
  ASSERT_TRUE(optimizer.Refine().at_rest);
  ASSERT_TRUE(optimizer.RemoveEdge(wrong).ok());
  EXPECT_GT(optimizer.Cost(), 1e-3);
  optimizer.Update();
  EXPECT_LT(optimizer.Cost(), 1e-9);
}

// Each window holds a few poses of what belongs together: they say so, and Refine gets there.
TYPED_TEST(ManyEdgesTest, WhereAllSeeAllRefineGetsToTheOptimum) {
  using G = TypeParam;
  OptimizerOptions options;
  options.window_edges = 100;
  options.max_top_edges = 150;
  Optimizer<G> optimizer(options);
  std::vector<G> truth;
  for (int k = 0; k < 60; ++k) {
    truth.push_back(RandomPose<G>(&this->rng_, 10, 1));
    const G start = k == 0 ? truth[0] : truth[k] * RandomPose<G>(&this->rng_, 1, 0.3);
    ASSERT_TRUE(optimizer.AddNode(k, start).ok());
    for (int j = 0; j < k; ++j) {
      const G Z = this->Measured(truth[j].Between(truth[k]));
      ASSERT_TRUE(optimizer.AddEdge(j, k, Z, this->information_).ok());
    }
    const UpdateReport report = optimizer.Update();
    if (report.at_rest) {
      EXPECT_LT(Gap(optimizer), 1e-2) << k;
    }
  }
  EXPECT_TRUE(optimizer.Refine().at_rest);
  EXPECT_LT(Gap(optimizer), 1e-6);
}

}  // namespace
}  // namespace hpgo
