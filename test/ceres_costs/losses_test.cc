#include "ceres_costs/losses.h"

#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace ceres_costs {
namespace {

struct Case {
  const char* name;
  double scale;
};

std::ostream& operator<<(std::ostream& out, const Case& c) {
  return out << c.name << " of scale " << c.scale;
}

class LossTest : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    std::string error;
    ASSERT_TRUE(MakeLoss(GetParam().name, GetParam().scale, &loss_, &error)) << error;
    ASSERT_NE(loss_, nullptr);
  }
  // The k-th derivative of rho at s.
  double Rho(double s, int k = 0) const {
    double rho[3];
    loss_->Evaluate(s, rho);
    return rho[k];
  }

  std::unique_ptr<ceres::LossFunction> loss_;
};

TEST_P(LossTest, IsTheSquaredErrorNearZero) {
  EXPECT_EQ(Rho(0), 0);
  EXPECT_NEAR(Rho(0, 1), 1, 1e-15);
  const double s = 1e-8 * GetParam().scale;
  EXPECT_NEAR(Rho(s) / s, 1, 1e-6);
}

TEST_P(LossTest, GrowsLessAndLess) {
  for (double s = 1e-3; s < 1e6; s *= 1.3) {
    EXPECT_GE(Rho(1.3 * s), Rho(s) * (1 - 1e-15)) << s;
    EXPECT_GE(Rho(s, 1), 0) << s;
    EXPECT_LE(Rho(1.3 * s, 1), Rho(s, 1)) << s;
    EXPECT_LE(Rho(s, 2), 0) << s;
  }
}

TEST_P(LossTest, DerivativesAgreeWithNumericOnes) {
  const double k = GetParam().scale;
  const double bend = std::string(GetParam().name) == "dcs" ? k : k * k;
  for (const double relative : {0.01, 0.3, 0.9, 1.1, 2.0, 30.0, 1e3}) {
    const double s = relative * bend, h = 1e-4 * s;  // never across the bend
    EXPECT_NEAR((Rho(s + h) - Rho(s - h)) / (2 * h), Rho(s, 1), 1e-7) << s;
    EXPECT_NEAR((Rho(s + h, 1) - Rho(s - h, 1)) / (2 * h), Rho(s, 2), 1e-7 / bend) << s;
  }
}

TEST_P(LossTest, IsContinuousAtTheBend) {
  const double k = GetParam().scale;
  for (const double bend : {k, k * k}) {
    EXPECT_NEAR(Rho(bend * (1 - 1e-12)), Rho(bend * (1 + 1e-12)), 1e-11 * bend);
    EXPECT_NEAR(Rho(bend * (1 - 1e-12), 1), Rho(bend * (1 + 1e-12), 1), 1e-11);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LossTest,
                         testing::Values(Case{"huber", 1.345}, Case{"huber", 0.1},
                                         Case{"cauchy", 2.3849}, Case{"cauchy", 30},
                                         Case{"tukey", 4.6851}, Case{"tukey", 0.5},
                                         Case{"geman_mcclure", 1}, Case{"geman_mcclure", 12},
                                         Case{"gm", 3}, Case{"dcs", 1}, Case{"dcs", 14}));

double Value(const std::string& name, double scale, double s) {
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  EXPECT_TRUE(MakeLoss(name, scale, &loss, &error)) << error;
  double rho[3] = {std::nan(""), 0, 0};
  if (loss != nullptr) loss->Evaluate(s, rho);
  return rho[0];
}

TEST(MakeLossTest, ValuesOfTheDocumentedFormulas) {
  EXPECT_EQ(Value("huber", 2, 4), 4);
  EXPECT_NEAR(Value("huber", 2, 25), 2 * 2 * 5 - 4, 1e-14);
  EXPECT_NEAR(Value("cauchy", 2, 12), 4 * std::log(4.0), 1e-14);
  EXPECT_NEAR(Value("tukey", 2, 2), 4.0 / 3 * (1 - 0.125), 1e-14);
  EXPECT_NEAR(Value("tukey", 2, 1e9), 4.0 / 3, 1e-14);
  EXPECT_NEAR(Value("geman_mcclure", 2, 4), 2, 1e-14);
  EXPECT_EQ(Value("gm", 2, 4), Value("geman_mcclure", 2, 4));
  EXPECT_EQ(Value("dcs", 2, 2), 2);
  EXPECT_NEAR(Value("dcs", 2, 6), 2 * (3 * 6 - 2) / 8.0, 1e-14);
  EXPECT_NEAR(Value("dcs", 2, 1e12), 6, 1e-9);
}

// Dynamic covariance scaling multiplies the information by the square of min(1, 2 Phi / (Phi + s)).
TEST(MakeLossTest, WeightOfDcsIsTheSquaredScale) {
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  ASSERT_TRUE(MakeLoss("dcs", 3, &loss, &error));
  double rho[3];
  loss->Evaluate(9, rho);
  EXPECT_NEAR(rho[1], 0.25, 1e-15);
}

TEST(MakeLossTest, NoneIsNullWhateverTheScale) {
  std::unique_ptr<ceres::LossFunction> loss = std::make_unique<ceres::HuberLoss>(1);
  std::string error;
  EXPECT_TRUE(MakeLoss("none", -1, &loss, &error));
  EXPECT_EQ(loss, nullptr);
  EXPECT_EQ(error, "");
}

TEST(MakeLossTest, NamesWhatIsWrong) {
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  EXPECT_FALSE(MakeLoss("Huber", 1, &loss, &error));
  EXPECT_EQ(error,
            "unknown loss \"Huber\"; known: none, huber, cauchy, tukey, geman_mcclure (gm), dcs");
  EXPECT_FALSE(MakeLoss("tukey", 0, &loss, &error));
  EXPECT_EQ(error, "the scale of loss \"tukey\" is 0; it must be positive and finite");
  EXPECT_FALSE(MakeLoss("dcs", std::nan(""), &loss, &error));
  EXPECT_EQ(error, "the scale of loss \"dcs\" is nan; it must be positive and finite");
  EXPECT_FALSE(MakeLoss("gm", std::numeric_limits<double>::infinity(), &loss, &error));
  EXPECT_EQ(error, "the scale of loss \"gm\" is inf; it must be positive and finite");
  EXPECT_EQ(loss, nullptr);
}

}  // namespace
}  // namespace ceres_costs
