#include "hpgo/report/axis_ticks.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;

std::vector<std::string> Labels(const std::vector<AxisTick>& ticks) {
  std::vector<std::string> labels;
  for (const AxisTick& tick : ticks) {
    if (!tick.label.empty()) labels.push_back(tick.label);
  }
  return labels;
}

TEST(RoundDown125Test, RoundsDown) {
  EXPECT_DOUBLE_EQ(RoundDown125(1), 1);
  EXPECT_DOUBLE_EQ(RoundDown125(1.99), 1);
  EXPECT_DOUBLE_EQ(RoundDown125(4.9), 2);
  EXPECT_DOUBLE_EQ(RoundDown125(73), 50);
  EXPECT_DOUBLE_EQ(RoundDown125(0.3), 0.2);
  EXPECT_DOUBLE_EQ(RoundDown125(1e-7), 1e-7);
}

TEST(LinearTicksTest, AreRoundAndWithinTheRange) {
  EXPECT_THAT(Labels(LinearTicks(0, 10, 5)), ElementsAre("0", "2", "4", "6", "8", "10"));
  EXPECT_THAT(Labels(LinearTicks(-1, 1, 4)), ElementsAre("-1", "-0.5", "0", "0.5", "1"));
  EXPECT_THAT(Labels(LinearTicks(0.13, 0.21, 4)), ElementsAre("0.14", "0.16", "0.18", "0.2"));
}

TEST(LogTicksTest, LabelsPowersOfTen) {
  const std::vector<AxisTick> ticks = LogTicks(1, 1000);
  EXPECT_EQ(ticks.size(), 28u);
  EXPECT_THAT(Labels(ticks), ElementsAre("1", "10", "100", "1k"));
}

TEST(LogTicksTest, LabelsMoreWhereTheRangeIsShort) {
  EXPECT_THAT(Labels(LogTicks(3, 60)), ElementsAre("5", "10", "20", "50"));
}

TEST(TickLabelTest, IsShort) {
  EXPECT_EQ(TickLabel(0), "0");
  EXPECT_EQ(TickLabel(0.05), "0.05");
  EXPECT_EQ(TickLabel(20000), "20k");
  EXPECT_EQ(TickLabel(2.5e6), "2.5M");
  EXPECT_EQ(TickLabel(1e-6), "1e-06");
  EXPECT_EQ(TickLabel(-1500), "-1.5k");
}

}  // namespace
}  // namespace hpgo
