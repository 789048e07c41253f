#include "hpgo/generate/random.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

// Fixed for ever: a seed names a graph.
TEST(RandomTest, ValuesOfASeed) {
  EXPECT_EQ(MixBits(0), 0xe220a8397b1dcdafu) << "the first output of SplitMix64 seeded with 0";
  Random random(1, 1);
  EXPECT_EQ(random.Uniform(), 0x1.b3370781c5d3ep-1);
}

TEST(RandomTest, StreamsAndSeedsDiffer) {
  Random a(1, 1), same(1, 1), other_stream(1, 2), other_seed(2, 1);
  const double first = a.Uniform();
  EXPECT_EQ(first, same.Uniform());
  EXPECT_NE(first, other_stream.Uniform());
  EXPECT_NE(first, other_seed.Uniform());
}

TEST(RandomTest, UniformMoments) {
  Random random(3, 0);
  double sum = 0, sum_sq = 0, low = 1, high = 0;
  constexpr int kDraws = 100000;
  for (int k = 0; k < kDraws; ++k) {
    const double u = random.Uniform();
    sum += u;
    sum_sq += u * u;
    low = std::min(low, u);
    high = std::max(high, u);
  }
  EXPECT_NEAR(sum / kDraws, 0.5, 0.005);
  EXPECT_NEAR(sum_sq / kDraws, 1.0 / 3, 0.005);
  EXPECT_GE(low, 0);
  EXPECT_LT(high, 1);
}

TEST(RandomTest, NormalMoments) {
  Random random(4, 0);
  double moment[5] = {};
  constexpr int kDraws = 200000;
  for (int k = 0; k < kDraws; ++k) {
    const double n = random.Normal();
    for (int m = 1; m <= 4; ++m) moment[m] += std::pow(n, m) / kDraws;
  }
  EXPECT_NEAR(moment[1], 0, 0.01);
  EXPECT_NEAR(moment[2], 1, 0.02);
  EXPECT_NEAR(moment[3], 0, 0.04);
  EXPECT_NEAR(moment[4], 3, 0.1);
}

TEST(RandomTest, BelowCoversItsRange) {
  Random random(5, 0);
  int count[3] = {};
  for (int k = 0; k < 3000; ++k) ++count[random.Below(3)];
  for (int c : count) EXPECT_NEAR(c, 1000, 120);
}

}  // namespace
}  // namespace hpgo
