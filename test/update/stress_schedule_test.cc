// The work that an update finds for its windows.

#include "gtest/gtest.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;

// A drive once around, whose dead reckoning turns by half as much. Two closures make it two loops.
PoseGraph<SE2> Lap(int nodes) {
  PoseGraph<SE2> graph;
  GraphEdge<SE2> edge;
  edge.information = 100 * SE2::Matrix::Identity();
  const double turn = 2 * EIGEN_PI / nodes;
  SE2 pose, truth, halfway;
  for (int k = 0; k < nodes; ++k) {
    (void)graph.AddNode({k, pose, false});
    if (k == nodes / 2) halfway = truth;
    pose = pose * SE2(1, 0, turn / 2);
    truth = truth * SE2(1, 0, turn);
    edge.i = k - 1;
    edge.j = k;
    edge.measurement = SE2(1, 0, turn / 2);
    if (k > 0) (void)graph.AddEdge(edge);
  }
  edge.i = 0;
  edge.j = nodes - 1;
  edge.measurement = truth * SE2(1, 0, turn).Inverse();
  (void)graph.AddEdge(edge);
  edge.j = nodes / 2;
  edge.measurement = halfway;
  (void)graph.AddEdge(edge);
  return graph;
}

// How often the first window on the lap is solved, by an update of one usual window.
int SolvesOfLap(int nodes, const UpdateLimits& limits = {}, double far_off = 1e9) {
  OptimizerOptions options;
  options.max_windows = 1;
  UpdateFixture<SE2> update(Lap(nodes), options);
  const StressThresholds thresholds = StressThresholds::FromMean(1, 1e-4);
  QueueAll(thresholds, &update.hierarchy());
  const Budget budget(limits);
  UpdateReport report;
  RunStressSchedule(update.tools(), {budget, thresholds, News(), far_off}, &report);
  EXPECT_EQ(report.windows + report.top_solves, 1);
  return report.solved_nodes / 2;  // two are free
}

// A few kept nodes are solved in no time; the chains between them take it.
TEST(StressScheduleTest, LinearizingLongChainsCountsAsWork) {
  EXPECT_GT(SolvesOfLap(50), 4);
  EXPECT_EQ(SolvesOfLap(1000), 1);
}

TEST(StressScheduleTest, WhatMissesMuchIsSolvedAgain) {
  EXPECT_EQ(SolvesOfLap(1000, {}, 0), 2);
  UpdateLimits limits;
  limits.max_seconds = 1e6;
  EXPECT_GE(SolvesOfLap(50, limits, 0), SolvesOfLap(50));
}

// Half way its edges are turned by more than a linearization reaches: the chains are to be cut
// first. Without that it is solved as often as one that fits.
TEST(StressScheduleTest, WhatChainsCannotFollowIsNotSolvedToItsEnd) {
  EXPECT_GE(SolvesOfLap(4), 1);
  EXPECT_LE(SolvesOfLap(4), SolvesOfLap(10) / 2);
}

}  // namespace
}  // namespace hpgo
