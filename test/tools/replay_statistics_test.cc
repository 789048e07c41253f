#include "tools/replay_statistics.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo_cli {
namespace {

UpdateSample Sample(int update, double wall_ms, bool closes_loop) {
  UpdateSample sample;
  sample.update = update;
  sample.closes_loop = closes_loop;
  sample.wall_ms = static_cast<float>(wall_ms);
  sample.cpu_ms = static_cast<float>(wall_ms / 2);
  sample.windows_ms = static_cast<float>(wall_ms / 4);
  return sample;
}

TEST(SummarizeLatencyTest, PercentilesAreSamples) {
  std::vector<float> values;
  for (int k = 100; k >= 1; --k) values.push_back(static_cast<float>(k));
  const LatencyFigures figures = SummarizeLatency(values);
  EXPECT_EQ(figures.p50, 50);
  EXPECT_EQ(figures.p95, 95);
  EXPECT_EQ(figures.p99, 99);
  EXPECT_EQ(figures.max, 100);
  EXPECT_NEAR(figures.mean, 50.5, 1e-9);
  const LatencyFigures one = SummarizeLatency({7});
  EXPECT_EQ(one.p50, 7);
  EXPECT_EQ(one.p99, 7);
  EXPECT_EQ(SummarizeLatency({1, 2, 3}).p50, 2);
  EXPECT_EQ(SummarizeLatency({}).max, 0);
}

TEST(SummarizeUpdatesTest, TellsClosuresFromOdometry) {
  const ReplayStatistics statistics = SummarizeUpdates(
      {Sample(1, 1, false), Sample(2, 8, true), Sample(3, 2, false), Sample(4, 4, true)});
  ASSERT_EQ(statistics.groups.size(), 3u);
  EXPECT_EQ(statistics.groups[0].name, "all");
  EXPECT_EQ(statistics.groups[0].count, 4);
  EXPECT_EQ(statistics.groups[0].wall.max, 8);
  EXPECT_EQ(statistics.groups[1].name, "closures");
  EXPECT_EQ(statistics.groups[1].count, 2);
  EXPECT_EQ(statistics.groups[1].cpu.p50, 2);
  EXPECT_EQ(statistics.groups[2].name, "odometry");
  EXPECT_EQ(statistics.groups[2].wall.max, 2);
  EXPECT_EQ(statistics.worst_update, 2);
  EXPECT_EQ(statistics.worst.windows, 2);
  EXPECT_EQ(statistics.worst.other, 6);
  EXPECT_DOUBLE_EQ(statistics.mean.windows, 15.0 / 16);
}

TEST(SummarizeUpdatesTest, NoUpdatesGiveZeros) {
  const ReplayStatistics statistics = SummarizeUpdates({});
  ASSERT_EQ(statistics.groups.size(), 3u);
  EXPECT_EQ(statistics.groups[0].count, 0);
  EXPECT_EQ(statistics.worst_update, 0);
}

}  // namespace
}  // namespace hpgo_cli
