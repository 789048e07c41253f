// The work that an update finds for its windows.

#include "gtest/gtest.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// A metre ahead, and a turn.
template <typename G>
G Ahead(double turn) {
  typename G::Tangent d = G::Tangent::Zero();
  d(0) = 1;
  d(G::kDof - 1) = turn;
  return G().Retract(d);
}

// A drive once around, whose dead reckoning turns by half as much. Two closures make it two loops.
template <typename G>
PoseGraph<G> Lap(int nodes) {
  PoseGraph<G> graph;
  GraphEdge<G> edge;
  edge.information = 100 * G::Matrix::Identity();
  const double turn = 2 * EIGEN_PI / nodes;
  G pose, truth, halfway;
  for (int k = 0; k < nodes; ++k) {
    (void)graph.AddNode({k, pose, false});
    if (k == nodes / 2) halfway = truth;
    pose = pose * Ahead<G>(turn / 2);
    truth = truth * Ahead<G>(turn);
    edge.i = k - 1;
    edge.j = k;
    edge.measurement = Ahead<G>(turn / 2);
    if (k > 0) (void)graph.AddEdge(edge);
  }
  edge.i = 0;
  edge.j = nodes - 1;
  edge.measurement = truth * Ahead<G>(turn).Inverse();
  (void)graph.AddEdge(edge);
  edge.j = nodes / 2;
  edge.measurement = halfway;
  (void)graph.AddEdge(edge);
  return graph;
}

// How often the first window on the lap is solved, by an update of one usual window.
template <typename G = SE2>
int SolvesOfLap(int nodes, const UpdateLimits& limits = {}, double far_off = 1e9) {
  OptimizerOptions options;
  options.max_windows = 1;
  UpdateFixture<G> update(Lap<G>(nodes), options);
  const StressThresholds thresholds = StressThresholds::FromMean(1, 1e-4);
  QueueAll(thresholds, &update.hierarchy());
  const Budget budget(limits);
  UpdateReport report;
  RunStressSchedule(update.tools(), {budget, thresholds, News(), far_off}, &report);
  EXPECT_EQ(report.windows + report.top_solves, 1);
  return report.solved_nodes / 2;  // two are free
}

// Else one that is damped, and so keeps what is pending, would starve all others.
TEST(StressScheduleTest, NoLevelWaitsWhereTimeBoundsAnUpdate) {
  OptimizerOptions options;
  options.max_windows = 7;
  UpdateLimits limits;
  const SweepLimits counted = SweepLimitsOf(options, Budget(limits));
  EXPECT_EQ(counted.max_windows, 7);
  EXPECT_GT(counted.least_share, 0);
  limits.max_cpu_seconds = 1;
  const SweepLimits timed = SweepLimitsOf(options, Budget(limits));
  EXPECT_EQ(timed.least_share, 0);
  EXPECT_GT(timed.max_windows, 1000);
  EXPECT_GT(timed.max_windows_per_level, 1000);
}

// A step that is not taken for the sake of the cost that is seen has solved nothing.
TEST(StressScheduleTest, AWindowThatMustNotMoveIsLookedAtAgain) {
  UpdateFixture<SE2> update(Lap<SE2>(100), OptimizerOptions());
  const StressThresholds thresholds = StressThresholds::FromMean(1, 1e-4);
  QueueAll(thresholds, &update.hierarchy());
  const Budget budget{UpdateLimits()};
  // The closures pull far away from what they measure.
  CondensedGraph<SE2>& graph = update.graph();
  for (const Index e : {99, 100}) {
    ASSERT_TRUE(graph.CanBePulled(e));
    const SE2 T = graph.RelativePose(e);
    const Eigen::Vector2d there =
        2 * T.translation() - graph.FactorOf(e).term->measurement.translation();
    graph.PullTowards(e, SE2(there.x(), there.y(), T.angle()), {1, 1});
  }
  for (int k = 0; k < 20; ++k) {
    UpdateReport report;
    const ScheduleResult result =
        RunStressSchedule(update.tools(), {budget, thresholds, News(), 1e9, false}, &report);
    EXPECT_GT(report.windows + report.top_solves, 0);
    EXPECT_EQ(result.decrease, 0);
    EXPECT_FALSE(result.at_rest);
  }
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

// In 3D an edge takes eight times as long.
TEST(StressScheduleTest, WhatTakesLongToLinearizeIsNotSolvedAgain) {
  EXPECT_GT(SolvesOfLap<SE3>(1000, {}, 0), 1);
  EXPECT_EQ(SolvesOfLap<SE3>(10000, {}, 0), 1);
}

// Half way its edges are turned by more than a linearization reaches: the chains are to be cut
// first. Without that it is solved as often as one that fits.
TEST(StressScheduleTest, WhatChainsCannotFollowIsNotSolvedToItsEnd) {
  EXPECT_GE(SolvesOfLap(4), 1);
  EXPECT_LE(SolvesOfLap(4), SolvesOfLap(10) / 2);
}

}  // namespace
}  // namespace hpgo
