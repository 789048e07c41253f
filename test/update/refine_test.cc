// How deep Refine goes: what a node gains that is moved alone, beside the mean chi2 of an edge, and
// who is moved.

#include <cmath>

#include "gtest/gtest.h"
#include "hpgo/optimizer.h"

namespace hpgo {
namespace {

constexpr double kMean = 0.5;  // chi2 of an edge, about

// Nodes that each hang on one held node and are a little off; they gain nothing for each other.
class RefineTest : public testing::Test {
 protected:
  static OptimizerOptions Options() {
    OptimizerOptions options;
    options.condense_chains = false;
    options.max_top_nodes = 2;
    options.window_nodes = 1;
    return options;
  }
  RefineTest() {
    // What the mean is made of: edges between held nodes, all of them off.
    for (int k = 0; k < 2; ++k) Add(k, 0);
    for (int k = 0; k < 2; ++k) EXPECT_TRUE(optimizer_.SetFixed(k, true).ok());
    for (int k = 0; k < 100; ++k) Connect(0, 1, SE2(1, 0, 0));
  }
  void Add(NodeId id, double x) { EXPECT_TRUE(optimizer_.AddNode(id, SE2(x, 0, 0)).ok()); }
  void Connect(NodeId i, NodeId j, const SE2& measurement) {
    EXPECT_TRUE(optimizer_.AddEdge(i, j, measurement, SE2::Matrix::Identity()).ok());
  }
  void AddNodes(NodeId first, int nodes) {
    for (NodeId id = first; id < first + nodes; ++id) {
      Add(id, 0);
      Connect(0, id, SE2());
    }
  }
  // So many of them, each of which gains `chi2`.
  void PutOff(NodeId first, int nodes, double chi2) {
    for (NodeId id = first; id < first + nodes; ++id) {
      EXPECT_TRUE(optimizer_.SetPose(id, SE2(std::sqrt(chi2), 0, 0)).ok());
    }
  }
  // All `nodes` of them; false if none is.
  bool AreMoved(NodeId first, int nodes) const {
    int moved = 0;
    for (NodeId id = first; id < first + nodes; ++id) {
      moved += std::abs(optimizer_.GetPose(id)->translation()(0)) < 1e-9;
    }
    EXPECT_TRUE(moved == 0 || moved == nodes) << moved;
    return moved == nodes;
  }

  Optimizer<SE2> optimizer_{Options()};
};

// The threshold is 5e-4 of the mean; Refine goes to a hundredth of it at least.
// The threshold is 5e-4 of the mean; Refine goes to a hundredth of it at least.
TEST_F(RefineTest, GoesToAHundredthOfTheThreshold) {
  AddNodes(100, 10);
  AddNodes(200, 10);
  optimizer_.Refine();  // new ones are put where they fit
  PutOff(100, 10, 2e-5 * kMean);
  PutOff(200, 10, 2e-6 * kMean);
  EXPECT_TRUE(optimizer_.Refine().at_rest);
  EXPECT_TRUE(AreMoved(100, 10));
  EXPECT_FALSE(AreMoved(200, 10));
}

// As long as that gains: where many are off by little, a tenth at a time.
TEST_F(RefineTest, GoesOnWhileItGains) {
  AddNodes(100, 100);
  AddNodes(200, 10);
  AddNodes(300, 10);
  optimizer_.Refine();
  PutOff(100, 100, 3e-5 * kMean);
  PutOff(200, 10, 2e-6 * kMean);
  PutOff(300, 10, 2e-7 * kMean);
  EXPECT_TRUE(optimizer_.Refine().at_rest);
  EXPECT_TRUE(AreMoved(100, 100));
  EXPECT_TRUE(AreMoved(200, 10));
  EXPECT_FALSE(AreMoved(300, 10));
}

// Updates measure what is left against an edge of level 0, and there a chain is one.
TEST(RefineOfChains, LeavesTheMeanOfLevel0) {
  for (const bool cut_short : {false, true}) {
    Optimizer<SE2> optimizer;
    for (int k = 0; k <= 30; ++k) {
      ASSERT_TRUE(optimizer.AddNode(k, SE2(k, 0, 0)).ok());
      if (k == 0) continue;
      ASSERT_TRUE(optimizer.AddEdge(k - 1, k, SE2(1.1, 0, 0), SE2::Matrix::Identity()).ok());
    }
    for (const int end : {0, 30}) ASSERT_TRUE(optimizer.SetFixed(end, true).ok());
    for (int k = 0; k < 300; ++k) optimizer.Update();  // whose samples outweigh those after it
    UpdateLimits limits;
    limits.max_cpu_seconds = cut_short ? 1e-9 : 0;
    ASSERT_EQ(optimizer.Refine(limits).at_rest, !cut_short);
    EXPECT_NEAR(optimizer.Cost(), 0.3, 1e-3);
    EXPECT_NEAR(optimizer.Update().mean_chi2, optimizer.Cost(), 0.1 * optimizer.Cost());
  }
}

}  // namespace
}  // namespace hpgo
