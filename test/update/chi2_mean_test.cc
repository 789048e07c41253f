#include "hpgo/update/chi2_mean.h"

#include <cmath>
#include <vector>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;

constexpr int kEdges = 100;

// A row of nodes at one place, every edge of it measured off so that it has the chi2 given.
Hierarchy<SE2> RowOf(const std::vector<double>& chi2) {
  Hierarchy<SE2> hierarchy;
  hierarchy.AddNode(SE2());
  for (const double c : chi2) {
    EdgeData<SE2> data;
    data.term = {SE2(std::sqrt(c), 0, 0), ceres_costs::PackedSymmetric<3>(SE2::Matrix::Identity())};
    const Index node = hierarchy.AddNode(SE2());
    const Index edge = hierarchy.AddEdge(node - 1, node, data);
    hierarchy.mutable_level(0).edges[edge].merged = true;
  }
  return hierarchy;
}

Hierarchy<SE2> RowOf(double chi2) { return RowOf(std::vector<double>(kEdges, chi2)); }

void Sample(const Hierarchy<SE2>& hierarchy, int updates, Chi2Mean* mean) {
  for (int k = 0; k < updates; ++k) mean->Sample(hierarchy, 0);
}

TEST(Chi2MeanTest, FollowsTheEstimateWithoutNews) {
  Chi2Mean mean;
  Sample(RowOf(1), 1, &mean);
  EXPECT_DOUBLE_EQ(mean.value(), 1);
  Sample(RowOf(0.25), 2000, &mean);
  EXPECT_LT(mean.value(), 0.27);  // what was long ago is forgotten
}

// Or windows would open, and not open, by chance.
TEST(Chi2MeanTest, IsThatOfManyEdges) {
  std::vector<double> chi2(kEdges, 0);
  for (int k = 0; k < kEdges; k += 2) chi2[k] = 2;
  const Hierarchy<SE2> row = RowOf(chi2);
  Chi2Mean mean;
  Sample(row, 500, &mean);
  for (int k = 0; k < 100; ++k) {
    Sample(row, 1, &mean);
    EXPECT_NEAR(mean.value(), 1, 0.1);
  }
}

// However much comes at once: an update may not look at all of a map.
TEST(Chi2MeanTest, OneUpdateLooksAtAFewEdgesOnly) {
  Chi2Mean mean;
  Sample(RowOf(1), 1000, &mean);
  mean.Sample(RowOf(0.0), 1'000'000);
  EXPECT_GT(mean.value(), 0.5);
  EXPECT_LT(mean.value(), 0.7);
}

// One that is far off until the next windows have moved it says nothing of the noise.
TEST(Chi2MeanTest, WhatDoesNotFitYetCountsForLittle) {
  std::vector<double> chi2(kEdges, 1);
  chi2[kEdges / 2] = 1e6;
  Chi2Mean mean;
  Sample(RowOf(1), 1000, &mean);
  Sample(RowOf(chi2), 1000, &mean);
  EXPECT_GT(mean.value(), 1.02);
  EXPECT_LT(mean.value(), 1.2);
}

TEST(Chi2MeanTest, RisesWithTheNoise) {
  Chi2Mean mean;
  Sample(RowOf(1), 1000, &mean);
  Sample(RowOf(1000), 5000, &mean);
  EXPECT_NEAR(mean.value(), 1000, 1);
}

}  // namespace
}  // namespace hpgo
