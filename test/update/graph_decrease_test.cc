#include "hpgo/update/graph_decrease.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "gtest/gtest.h"
#include "hpgo/update/constants.h"
#include "test/hierarchy/level_cost.h"
#include "test/solve/small_graphs.h"
#include "test/solve/small_hierarchies.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// A window of all of the top, above at least two levels.
template <typename G>
class Top {
 public:
  Top(int nodes, double noise, const HierarchyOptions& options)
      : hierarchy_(MakeHierarchy(MakeKnownGraph<G>(nodes, noise, 1).graph, options)) {
    EXPECT_GE(hierarchy_.num_levels(), 3);
    EXPECT_TRUE(window_.BuildWhole(hierarchy_.num_levels() - 1, &hierarchy_));
  }

  // Moves poses of the window by so many m and rad, and those of the hierarchy; but for a few at
  // the end a hundredth of that.
  void Step(double m, double rad, unsigned seed, bool few = false) {
    std::mt19937_64 rng(seed);
    for (int k = 0; k < window_.num_free(); ++k) {
      G& pose = window_.subproblem().poses[k];
      const double share = few && 20 * k < 19 * window_.num_free() ? 0.01 : 1;
      pose = (pose * RandomPose<G>(&rng, share * m, share * rad)).Normalized();
    }
    const double level = CostOfLevel(hierarchy_, window_.level()),
                 graph = CostOfLevel(hierarchy_, 0);
    window_.Commit(&hierarchy_);
    promised_ = level - CostOfLevel(hierarchy_, window_.level());
    decrease_ = graph - CostOfLevel(hierarchy_, 0);
  }
  double promised() const { return promised_; }
  double decrease() const { return decrease_; }
  double Asked(Asking asking) const { return Asked(asking, promised_); }
  double Asked(Asking asking, double promised) const {
    const int l = window_.level();
    std::vector<double> changes;
    for (std::size_t k = 0; k < window_.edges().size(); ++k) {
      changes.push_back(FactorChange(hierarchy_.FactorOf(l, window_.edges()[k]), false,
                                     window_.RelativePoseBefore(k), window_.RelativePose(k)));
    }
    return GraphDecrease(window_, promised, changes, hierarchy_, asking);
  }
  int num_edges() const { return hierarchy_.level(0).num_edges; }

 private:
  Hierarchy<G> hierarchy_;
  Window<G> window_;
  double promised_ = 0, decrease_ = 0;
};

template <typename G>
class GraphDecreaseTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(GraphDecreaseTest, Groups);

HierarchyOptions SmallTop(int nodes) {
  HierarchyOptions options;
  options.max_top_nodes = nodes;
  return options;
}

TYPED_TEST(GraphDecreaseTest, IsThatOfLevel0WhereAllAreAsked) {
  double missed = 0;
  for (unsigned seed = 0; seed < 10; ++seed) {
    Top<TypeParam> top(200, 0.05, SmallTop(8));
    top.Step(0.5, 0.5, seed);
    missed = std::max(missed, std::abs(top.promised() / top.decrease() - 1));
    EXPECT_NEAR(top.Asked(Asking::kAll), top.decrease(), 1e-9 * std::abs(top.decrease()));
  }
  EXPECT_GT(missed, 0.1);
}

TYPED_TEST(GraphDecreaseTest, IsWhatIsPromisedWhereLittleOfItCanBeMissed) {
  Top<TypeParam> top(200, 0.05, SmallTop(8));
  top.Step(1e-3, 1e-6, 1);
  const double much = 1000;
  EXPECT_EQ(top.Asked(Asking::kWhereInDoubt, much), much);
  EXPECT_NEAR(top.Asked(Asking::kAll, much), top.decrease(), 1e-9);
}

// Of more than may be looked at, those are asked first that may miss most.
TYPED_TEST(GraphDecreaseTest, WhatIsNotAskedMissesLittleBesideWhatIs) {
  Top<TypeParam> top(20000, 0.05, SmallTop(5000));
  EXPECT_GT(top.num_edges(), 1.5 * kMostOfAllAsked);
  top.Step(0.3, 0.3, 1, true);
  const double missed = std::abs(top.promised() - top.decrease());
  const double left = std::abs(top.Asked(Asking::kAll) - top.decrease());
  EXPECT_GT(left, 1e-6 * missed);
  EXPECT_LT(left, 0.01 * missed);
}

}  // namespace
}  // namespace hpgo
