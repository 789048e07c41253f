#include "hpgo/hierarchy/grouping.h"

#include "gtest/gtest.h"

namespace hpgo {
namespace {

TEST(GroupingTest, GainIsThePapersFormula) {
  EXPECT_DOUBLE_EQ(ModularityGain({0, 1, 3., 4.}, 5., 10.), 3. / 20 - 4. * 5. / 200);
}

TEST(GroupingTest, TakesTheLargestPositiveGain) {
  EXPECT_EQ(BestGroup({{0, 1, 1., 1.}, {1, 2, 2., 1.}}, 1., 10., 3), 1);
}

TEST(GroupingTest, PassesOverFullGroups) {
  EXPECT_EQ(BestGroup({{0, 1, 1., 1.}, {1, 3, 2., 1.}}, 1., 10., 3), 0);
}

TEST(GroupingTest, StaysAloneWhereNothingIsGained) {
  EXPECT_EQ(BestGroup({{0, 1, 1., 20.}}, 2., 10., 3), -1);
  EXPECT_EQ(BestGroup({}, 2., 10., 3), -1);
}

TEST(GroupingTest, TakesTheFirstOfEquals) {
  EXPECT_EQ(BestGroup({{7, 1, 1., 1.}, {8, 1, 1., 1.}}, 1., 10., 3), 0);
}

}  // namespace
}  // namespace hpgo
