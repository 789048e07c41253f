#include "hpgo/schedule/sweep.h"

#include <string>
#include <vector>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

// Levels with a given amount of work, served one unit at a time.
struct FakeLevels {
  std::vector<int> work;
  std::vector<double> pending;
  std::string order;  // the levels served, in turn
  int stop_after = 1000;
  int worth = 1;        // of a window
  int stop_level = -1;  // stops before serving it

  SweepActions Actions() {
    SweepActions actions;
    actions.serve = [this](int level) {
      if (work[level] == 0) return 0;
      --work[level];
      order += std::to_string(level);
      return worth;
    };
    actions.largest_pending = [this](int level) {
      return pending.empty() ? static_cast<double>(work[level]) : pending[level];
    };
    actions.stop = [this](int level) {
      return level == stop_level || static_cast<int>(order.size()) >= stop_after;
    };
    return actions;
  }
};

constexpr double kThreshold = 0.5;

TEST(SweepTest, ServesTopToBottomInTurns) {
  FakeLevels levels{{2, 1, 2}, {}, "", 1000};
  Sweep sweep;
  EXPECT_TRUE(sweep.Run(3, {100, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "21020");
}

TEST(SweepTest, RestsAtOnceWhereThereIsNoWork) {
  FakeLevels levels{{0, 0}, {}, "", 1000};
  EXPECT_TRUE(Sweep().Run(2, {6, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "");
}

TEST(SweepTest, KeepsTheShareOfALevel) {
  FakeLevels levels{{5, 0, 1}, {}, "", 1000};
  EXPECT_FALSE(Sweep().Run(3, {100, 2}, kThreshold, levels.Actions())) << "work is left";
  EXPECT_EQ(levels.order, "200");
}

TEST(SweepTest, StopsBeforeALevelThatWouldTakeTooLong) {
  FakeLevels levels{{9, 9, 9}, {}, "", 1000, 1, 1};
  Sweep sweep;
  EXPECT_FALSE(sweep.Run(3, {100, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "2");
  levels.stop_level = -1;
  levels.pending = {1, 1, 1};
  EXPECT_FALSE(sweep.Run(3, {1, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "21") << "the next goes on there";
}

TEST(SweepTest, ALargerWindowCountsForMore) {
  FakeLevels levels{{9, 9, 9}, {}, "", 1000, 3};
  EXPECT_FALSE(Sweep().Run(3, {6, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "21");
}

TEST(SweepTest, ResumesBelowWhereTheLimitHitIt) {
  FakeLevels levels{{9, 9, 9}, {1, 1, 1}, "", 1000};
  Sweep sweep;
  EXPECT_FALSE(sweep.Run(3, {2, 2}, kThreshold, levels.Actions()));
  EXPECT_FALSE(sweep.Run(3, {2, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "2102");
}

TEST(SweepTest, StartsAtTheTopWhenTold) {
  FakeLevels levels{{9, 9, 9}, {1, 1, 1}, "", 1000};
  Sweep sweep;
  EXPECT_FALSE(sweep.Run(3, {2, 2}, kThreshold, levels.Actions()));
  sweep.StartAtTop();
  EXPECT_FALSE(sweep.Run(3, {2, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "2121");
}

TEST(SweepTest, ResumesAtTheTopWhereThatHasMorePending) {
  FakeLevels levels{{9, 9, 9}, {1, 1, 5}, "", 1000};
  Sweep sweep;
  EXPECT_FALSE(sweep.Run(3, {2, 2}, kThreshold, levels.Actions()));
  EXPECT_FALSE(sweep.Run(3, {1, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "212");
}

TEST(SweepTest, DoesNotResumeAtALevelBelowTheThreshold) {
  FakeLevels levels{{9, 9, 9}, {0.1, 0.1, 0.1}, "", 1000};
  Sweep sweep;
  EXPECT_FALSE(sweep.Run(3, {2, 2}, kThreshold, levels.Actions()));
  EXPECT_FALSE(sweep.Run(3, {1, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "212");
}

// Where one level could gain a hundred times as much, windows elsewhere are wasted.
TEST(SweepTest, ALevelWithLittlePendingWaits) {
  FakeLevels levels{{1, 1, 3}, {1, 1.2, 15}, "", 1000};
  EXPECT_TRUE(Sweep().Run(3, {100, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "22210");
  levels = {{1, 1, 3}, {2, 2, 15}, "", 1000};
  EXPECT_TRUE(Sweep().Run(3, {100, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "21022");
}

// Windows that one level may not have are for the others.
TEST(SweepTest, NoLevelWaitsForOneThatHasHadItsShare) {
  FakeLevels levels{{1, 5}, {1, 15}, "", 1000};
  EXPECT_FALSE(Sweep().Run(2, {100, 2}, kThreshold, levels.Actions())) << "work is left";
  EXPECT_EQ(levels.order, "110");
}

// Nor does one wait for another that has no work for now, whatever is pending there.
TEST(SweepTest, NoLevelWaitsForOneWithoutWork) {
  FakeLevels levels{{1, 0}, {1, 15}, "", 1000};
  EXPECT_TRUE(Sweep().Run(2, {100, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "0");
}

TEST(SweepTest, StopsWhenTold) {
  FakeLevels levels{{9, 9}, {}, "", 3};
  EXPECT_FALSE(Sweep().Run(2, {100, 100}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "101");
}

TEST(SweepTest, SurvivesALevelThatIsGone) {
  FakeLevels levels{{9, 9, 9, 9}, {1, 1, 1, 1}, "", 1000};
  Sweep sweep;
  EXPECT_FALSE(sweep.Run(4, {2, 2}, kThreshold, levels.Actions()));
  EXPECT_FALSE(sweep.Run(1, {1, 2}, kThreshold, levels.Actions()));
  EXPECT_EQ(levels.order, "320");
}

}  // namespace
}  // namespace hpgo
