// The moment after a loop closure over a long chain, where windows alone are far off.

#include <random>

#include "gtest/gtest.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class ClosureTest : public testing::Test {
 protected:
  // Drives `laps` times around a square of 4 * `side` nodes, an update a node, and sees the first
  // lap's nodes again every `every` nodes; returns the largest gap right after such an update.
  double LargestGap(const OptimizerOptions& options, int side, int laps, int every) {
    Optimizer<G> optimizer(options);
    G step;
    step.translation()(0) = 1;
    typename G::Tangent corner = G::Tangent::Zero();
    corner(G::kDof - 1) = std::acos(-1.0) / 2;
    const G turn = step * G().Retract(corner);
    std::vector<G> truth{G()};
    const int lap = 4 * side;
    for (int k = 1; k < laps * lap; ++k) {
      truth.push_back(truth.back() * (k % side == 0 ? turn : step));
    }
    const typename G::Matrix information = 1e4 * G::Matrix::Identity();
    const auto measure = [&](int i, int j) {
      return truth[i].Between(truth[j]) * RandomPose<G>(&rng_, 0.01, 0.003);
    };
    double largest = 0;
    EXPECT_TRUE(optimizer.AddNode(0, truth[0]).ok());
    for (int k = 1; k < laps * lap; ++k) {
      const G Z = measure(k - 1, k);
      EXPECT_TRUE(optimizer.AddNode(k, *optimizer.GetPose(k - 1) * Z).ok());
      EXPECT_TRUE(optimizer.AddEdge(k - 1, k, Z, information).ok());
      const bool closes = k >= lap && k % every == 0;
      if (closes) {
        EXPECT_TRUE(optimizer.AddEdge(k - lap, k, measure(k - lap, k), information).ok());
      }
      EXPECT_TRUE(optimizer.Update().status.ok());
      if (closes) largest = std::max(largest, Gap(optimizer));
    }
    EXPECT_EQ(optimizer.FindInconsistency(), "");
    kept_ = optimizer.hierarchy().level(0).num_nodes;
    return largest;
  }

  std::mt19937_64 rng_{3};
  int kept_ = 0;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(ClosureTest, Groups);

TYPED_TEST(ClosureTest, IsTakenInByOneUpdate) {
  EXPECT_LT(this->LargestGap(OptimizerOptions(), 100, 3, 90), 0.02);
  EXPECT_LT(this->kept_, 40);  // of 1,200 nodes
}

// What the condensed chains are for: without them the same update ends far off.
TYPED_TEST(ClosureTest, WithoutChainsItIsFarOff) {
  OptimizerOptions options;
  options.condense_chains = false;
  options.max_top_nodes = 150;
  EXPECT_GT(this->LargestGap(options, 100, 2, 390), 0.5);
  EXPECT_EQ(this->kept_, 800);
}

// New nodes posed in an estimate that is long past go where their edges say.
TYPED_TEST(ClosureTest, StalePosesAreTakenInAtOnce) {
  Optimizer<TypeParam> optimizer;
  TypeParam step, elsewhere;
  step.translation()(0) = 1;
  elsewhere.translation()(1) = 25;
  const typename TypeParam::Matrix information = TypeParam::Matrix::Identity();
  ASSERT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
  TypeParam stale = elsewhere;
  for (int k = 1; k < 200; ++k) {
    stale = stale * step;
    ASSERT_TRUE(optimizer.AddNode(k, stale).ok());
    ASSERT_TRUE(optimizer.AddEdge(k - 1, k, step, information).ok());
    if (k % 50 == 0) optimizer.Update();
  }
  optimizer.Update();
  EXPECT_LT(optimizer.Cost(), 1e-9);
}

}  // namespace
}  // namespace hpgo
