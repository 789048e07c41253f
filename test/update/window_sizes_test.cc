#include "hpgo/update/window_sizes.h"

#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

constexpr double kFill = 1.3;  // the power with which the time of a window grows

class WindowSizesTest : public testing::Test {
 protected:
  WindowSizesTest() {
    options_.window_nodes = 100;
    options_.window_edges = 500;
  }
  Budget Seconds(double seconds, bool to_rest = false) const {
    UpdateLimits limits;
    limits.max_seconds = seconds;
    return Budget(limits, to_rest, {[] { return 0.; }, [] { return 0.; }});
  }

  OptimizerOptions options_;
};

TEST_F(WindowSizesTest, AreTheOptionsWithoutALimit) {
  WindowSizes sizes(options_);
  for (int k = 0; k < 10; ++k) sizes.Learn(0, 1, 1e-3, false);
  const WindowLimits next = sizes.Next(0, Seconds(0));
  EXPECT_EQ(next.max_nodes, 100);
  EXPECT_EQ(next.max_edges, 500);
}

TEST_F(WindowSizesTest, FollowTheTimeThatRecentOnesTook) {
  WindowSizes sizes(options_);
  EXPECT_EQ(sizes.Next(0, Seconds(1)).max_nodes, 100);  // nothing is known
  for (int k = 0; k < 20; ++k) sizes.Learn(0, 1, 1e-3, false);
  // A window may take 0.35 of the limit.
  const double scale = std::pow(0.35 * 0.01 / 1e-3, 1 / kFill);
  const WindowLimits next = sizes.Next(0, Seconds(0.01));
  EXPECT_EQ(next.max_nodes, static_cast<int>(100 * scale));
  EXPECT_EQ(next.max_edges, static_cast<int>(500 * scale));
  EXPECT_EQ(sizes.Next(0, Seconds(0.002)).max_nodes, 100);  // never smaller
  EXPECT_EQ(sizes.Next(3, Seconds(0.01)).max_nodes,
            next.max_nodes);  // another level: as the slowest
}

TEST_F(WindowSizesTest, GrowStepByStepAndShrinkAtOnce) {
  WindowSizes sizes(options_);
  sizes.Learn(0, 1, 1e-9, false);
  EXPECT_EQ(sizes.Next(0, Seconds(1)).max_nodes, 150);
  sizes.Learn(0, 1, 1e-9, false);
  EXPECT_EQ(sizes.Next(0, Seconds(1)).max_nodes, 225);
  for (int k = 0; k < 20; ++k) sizes.Learn(0, 1, 1e-9, false);
  EXPECT_EQ(sizes.Next(0, Seconds(1)).max_nodes, 2000);  // 20 times, and no more
  EXPECT_EQ(sizes.Next(0, Seconds(0, true)).max_nodes, 2000);
  sizes.Learn(0, 1, 1e-9, true);
  EXPECT_EQ(sizes.Next(0, Seconds(1)).max_nodes, 100);
}

TEST_F(WindowSizesTest, LearnSlowerTimesFaster) {
  WindowSizes slower(options_), faster(options_);
  slower.Learn(0, 1, 1, false);
  slower.Learn(0, 1, 2, false);
  EXPECT_DOUBLE_EQ(slower.SecondsOf(1, 0), 1.5);
  faster.Learn(0, 1, 2, false);
  faster.Learn(0, 1, 1, false);
  EXPECT_DOUBLE_EQ(faster.SecondsOf(1, 0), 1.8);
  faster.Learn(0, 0.4, 1e-9, false);  // too small to say much
  EXPECT_DOUBLE_EQ(faster.SecondsOf(1, 0), 1.8);
  EXPECT_DOUBLE_EQ(faster.SecondsOf(2, 0), 1.8 * std::pow(2, kFill));
}

TEST_F(WindowSizesTest, CountWindowsByTheLargerOfNodesAndEdges) {
  const WindowSizes sizes(options_);
  EXPECT_DOUBLE_EQ(sizes.Worth(50, 1000), 2);
  EXPECT_DOUBLE_EQ(sizes.Worth(300, 10), 3);
}

}  // namespace
}  // namespace hpgo
