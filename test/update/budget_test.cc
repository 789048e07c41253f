#include "hpgo/update/budget.h"

#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

class BudgetTest : public testing::Test {
 protected:
  Budget Make(double wall_limit, double cpu_limit, bool to_rest = false) {
    UpdateLimits limits;
    limits.max_seconds = wall_limit;
    limits.max_cpu_seconds = cpu_limit;
    limits.cancel = &cancel_;
    return Budget(limits, to_rest, {[this] { return wall_; }, [this] { return cpu_; }});
  }

  double wall_ = 100, cpu_ = 7;
  std::atomic<bool> cancel_{false};
};

TEST_F(BudgetTest, HasNoEndWithoutALimit) {
  const Budget budget = Make(0, 0);
  wall_ += 1e6;
  EXPECT_FALSE(budget.HasTimeLimit());
  EXPECT_FALSE(budget.IsUncapped());
  EXPECT_TRUE(std::isinf(budget.SecondsLeft()));
  EXPECT_TRUE(std::isinf(budget.SecondsForWindow()));
  EXPECT_FALSE(budget.IsStopped());
  EXPECT_EQ(budget.Rest().max_seconds, 0);
  EXPECT_TRUE(Make(0, 0, true).IsUncapped());
}

TEST_F(BudgetTest, EndsByWallTime) {
  const Budget budget = Make(2, 0);
  wall_ += 0.5;
  EXPECT_DOUBLE_EQ(budget.SecondsLeft(), 1.5);
  EXPECT_DOUBLE_EQ(budget.SecondsForWindow(), 0.35 * 2);
  EXPECT_DOUBLE_EQ(budget.Rest().max_seconds, 1.5);
  wall_ += 1.25;  // less is left than the share of a window
  EXPECT_DOUBLE_EQ(budget.SecondsForWindow(), 0.25);
  EXPECT_FALSE(budget.IsStopped());
  wall_ += 1;
  EXPECT_TRUE(budget.IsStopped());
  EXPECT_GT(budget.Rest().max_seconds, 0);  // 0 would be no limit
}

TEST_F(BudgetTest, EndsByCpuTimeWhateverTheWallSays) {
  const Budget budget = Make(0, 2);
  wall_ += 1e6;
  cpu_ += 1.5;
  EXPECT_DOUBLE_EQ(budget.SecondsLeft(), 0.5);
  EXPECT_FALSE(budget.IsStopped());
  cpu_ += 1;
  EXPECT_TRUE(budget.IsStopped());
}

TEST_F(BudgetTest, TheShorterLimitCounts) {
  const Budget budget = Make(10, 2);
  wall_ += 9;
  cpu_ += 0.5;
  EXPECT_DOUBLE_EQ(budget.SecondsLeft(), 1);
  cpu_ += 1;
  EXPECT_DOUBLE_EQ(budget.SecondsLeft(), 0.5);
  EXPECT_DOUBLE_EQ(budget.SecondsForWindow(), 0.5);
}

TEST_F(BudgetTest, IsStoppedFromElsewhere) {
  const Budget budget = Make(0, 0);
  EXPECT_FALSE(budget.IsStopped());
  cancel_ = true;
  EXPECT_TRUE(budget.IsCancelled());
  EXPECT_TRUE(budget.IsStopped());
}

}  // namespace
}  // namespace hpgo
