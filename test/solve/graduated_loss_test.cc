#include "hpgo/solve/graduated_loss.h"

#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

double Rho(const ceres::LossFunction& loss, double s) {
  double rho[3];
  loss.Evaluate(s, rho);
  return rho[0];
}

TEST(GraduatedLossTest, ARedescendingLossFollowsHuberAndItsOwnWiderForms) {
  const auto dcs = GraduatedLosses("dcs", 4);  // bends where s = 4: an error of 2
  ASSERT_EQ(dcs.size(), 4);
  EXPECT_DOUBLE_EQ(Rho(*dcs[0], 100), 2 * 2 * 10 - 4);
  EXPECT_DOUBLE_EQ(Rho(*dcs[1], 100), 64 * (300. - 64) / 164);
  EXPECT_DOUBLE_EQ(Rho(*dcs[2], 100), 16 * (300. - 16) / 116);
  EXPECT_DOUBLE_EQ(Rho(*dcs[3], 100), 4 * (300. - 4) / 104);

  for (const char* name : {"geman_mcclure", "gm"}) {
    const auto losses = GraduatedLosses(name, 3);
    ASSERT_EQ(losses.size(), 4) << name;
    EXPECT_DOUBLE_EQ(Rho(*losses[0], 100), 2 * 3 * 10 - 9);
    EXPECT_DOUBLE_EQ(Rho(*losses[1], 100), 100 / (1 + 100. / 144));
    EXPECT_DOUBLE_EQ(Rho(*losses[2], 100), 100 / (1 + 100. / 36));
    EXPECT_DOUBLE_EQ(Rho(*losses[3], 100), 100 / (1 + 100. / 9));
  }
  const auto tukey = GraduatedLosses("tukey", 3);
  ASSERT_EQ(tukey.size(), 4);
  EXPECT_DOUBLE_EQ(Rho(*tukey[1], 1000), 144 / 3.);
  EXPECT_DOUBLE_EQ(Rho(*tukey[3], 1000), 9 / 3.);
}

TEST(GraduatedLossTest, OthersStandAlone) {
  for (const char* name : {"huber", "cauchy"}) {
    const auto losses = GraduatedLosses(name, 2);
    ASSERT_EQ(losses.size(), 1) << name;
    EXPECT_DOUBLE_EQ(Rho(*losses[0], 12),
                     name[0] == 'h' ? 2 * 2 * std::sqrt(12.) - 4 : 4 * std::log(4.));
  }
  const auto none = GraduatedLosses("none", 0);
  ASSERT_EQ(none.size(), 1);
  EXPECT_EQ(none[0], nullptr);
}

}  // namespace
}  // namespace hpgo
