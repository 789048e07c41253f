// Merges under a limit of time.

#include "gtest/gtest.h"
#include "test/solve/small_graphs.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

class MergeTest : public testing::Test {
 protected:
  // Merges what is dirty, with a clock that goes on by so many seconds whenever it is looked at.
  UpdateReport Merge(double seconds_a_look, double limit) {
    UpdateFixture<SE2> update(MakeKnownGraph<SE2>(3000, 0.01, 7).graph);
    UpdateLimits limits;
    limits.max_seconds = limit;
    const auto clock = [&] { return seconds_a_look * ++looks_; };
    const Budget budget(limits, false, {clock, clock});
    UpdateReport report;
    MergeDirty(update.tools(), {budget, StressThresholds::FromMean(1, 1e-3), News(), 1e9}, &report);
    return report;
  }

  int looks_ = 0;
};

// To look at the time of the thread costs a third of a merge.
TEST_F(MergeTest, LooksAtTheClockNowAndThen) {
  const UpdateReport report = Merge(0, 1);
  EXPECT_GT(report.merged_edges, 1000);
  EXPECT_LT(looks_, report.merged_edges / 20);
}

TEST_F(MergeTest, EndsSoonAfterItsTime) {
  const UpdateReport report = Merge(1, 3.5);
  EXPECT_GT(report.merged_edges, 0);
  EXPECT_LT(report.merged_edges, 300);
}

}  // namespace
}  // namespace hpgo
