// Steps that are judged by the cost their caller sees.

#include "hpgo/update/seen_cost.h"

#include <limits>
#include <string>

#include "gtest/gtest.h"
#include "hpgo/solve/solver_factory.h"
#include "hpgo/update/window_step.h"
#include "test/hierarchy/level_cost.h"
#include "test/solve/small_graphs.h"
#include "test/solve/small_hierarchies.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

HierarchyOptions SmallTop() {
  HierarchyOptions options;
  options.max_top_nodes = 20;
  return options;
}

// A walk that is off, and a window of a whole level. One edge measures something that its ends go
// away from when the window is solved: it only pulls to where they go.
template <typename G>
class Walk {
 public:
  Walk(int l, bool may_rise, double way)
      : level_(l),
        hierarchy_(MakeHierarchy(MakeKnownGraph<G>(60, 0.3, 1).graph, SmallTop())),
        step_(Engine::kBlock, &hierarchy_, [](Index e) { return std::to_string(e); }) {
    EXPECT_GT(hierarchy_.num_levels(), 1);
    seen_.may_rise = may_rise;
    EXPECT_TRUE(step_.window().BuildWhole(l, &hierarchy_));
    EXPECT_TRUE(MakeSolver<G>(Engine::kBlock)->Solve({}, &step_.window().subproblem()).status.ok());
    typename G::Tangent away = G::Tangent::Zero();
    for (Index e = 0; e < static_cast<Index>(hierarchy_.level(0).edges.size()); ++e) {
      const auto& ends = hierarchy_.level(0).edges[e].node;
      const auto poses = step_.window().PosesBetween(ends[0], ends[1]);
      if (!poses) continue;  // within a group
      typename G::Tangent d = poses->first.Minus(poses->second);
      d.template tail<G::kRotationDof>().setZero();
      if (d.norm() < away.norm()) continue;
      away = d;
      pulled_ = e;
    }
    seen_.pulled = {{pulled_, hierarchy_.level(0).terms[pulled_]}};
    const auto& ends = hierarchy_.level(0).edges[pulled_].node;
    seen_.pulled.front().measured.measurement =
        hierarchy_.RelativePose(0, ends[0], ends[1]).Plus(way * away);
  }
  StepResult Solve() {
    EXPECT_TRUE(step_.window().BuildWhole(level_, &hierarchy_));
    return step_.Solve(10, kInfinity, StressThresholds::FromMean(1, 1e-3), Budget(UpdateLimits()),
                       seen_);
  }
  double Cost() const {
    ceres_costs::FactorTerm<G> factor = hierarchy_.FactorOf(0, pulled_);
    const auto& ends = hierarchy_.level(0).edges[pulled_].node;
    const G T = hierarchy_.RelativePose(0, ends[0], ends[1]);
    const double pull = FactorCost(factor, false, T);
    factor.term = &seen_.pulled.front().measured;
    return CostOfLevel(hierarchy_, 0) - pull + FactorCost(factor, false, T);
  }

 private:
  int level_;
  Hierarchy<G> hierarchy_;
  WindowStep<G> step_;
  Index pulled_ = 0;
  SeenCost<G> seen_;
};

template <typename G>
class SeenCostTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(SeenCostTest, Groups);

// Times what a step moves.
constexpr double kFarAway = 1000, kFarAhead = -1000;

TYPED_TEST(SeenCostTest, AStepThatRaisesItIsNotTaken) {
  for (const int l : {0, 1}) {
    Walk<TypeParam> walk(l, false, kFarAway);
    const double before = walk.Cost();
    const StepResult step = walk.Solve();
    EXPECT_TRUE(step.is_seen_to_rise);
    EXPECT_EQ(step.decrease, 0);
    EXPECT_EQ(walk.Cost(), before);
  }
}

TYPED_TEST(SeenCostTest, WhereItMayRiseItIs) {
  for (const int l : {0, 1}) {
    Walk<TypeParam> walk(l, true, kFarAway);
    const double before = walk.Cost();
    const StepResult step = walk.Solve();
    EXPECT_FALSE(step.is_seen_to_rise);
    EXPECT_GT(step.decrease, 0);
    EXPECT_GT(walk.Cost(), before);
  }
}

TYPED_TEST(SeenCostTest, OneThatLowersItIs) {
  for (const int l : {0, 1}) {
    Walk<TypeParam> walk(l, false, kFarAhead);
    const double before = walk.Cost();
    EXPECT_GT(walk.Solve().decrease, 0);
    EXPECT_LT(walk.Cost(), before);
  }
}

}  // namespace
}  // namespace hpgo
