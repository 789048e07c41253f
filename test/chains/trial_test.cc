// Chains whose ends move, and are taken back: they are what they were.

#include <cmath>
#include <cstdint>

#include "ceres_costs/factor_term.h"
#include "gtest/gtest.h"
#include "hpgo/chains/condensed_graph.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// A chain of 64 edges ahead between two nodes that are held, its last edge a metre off.
template <typename G>
class TrialTest : public testing::Test {
 protected:
  static constexpr int kEdges = 64;
  TrialTest() : graph_(HierarchyOptions(), true) {
    typename G::Tangent ahead = G::Tangent::Zero();
    ahead(0) = 1;
    EdgeData<G> data;
    data.term.measurement = G().Plus(ahead);
    data.term.information =
        ceres_costs::PackedSymmetric<G::kDof>((1e4 * G::Matrix::Identity()).eval());
    G pose;
    graph_.AddNode(pose);
    for (int k = 1; k <= kEdges; ++k) {
      pose = pose * data.term.measurement;
      graph_.AddNode(pose);
      graph_.AddEdge(k - 1, k, data);
    }
    graph_.SetTolerance(1e-3);
    graph_.SetHeld(0, true);
    graph_.SetHeld(kEdges, true);
    graph_.Restructure();
    edge_ = graph_.LevelEdgeOf(0);
  }
  // Of the ends, with the last one moved by so much to the side.
  G Aside(double distance) {
    typename G::Tangent d = G::Tangent::Zero();
    d(1) = distance;
    return graph_.WorldPose(kEdges).Plus(d);
  }
  bool Lags() const { return graph_.hierarchy().level(0).edges[edge_].lags; }
  double Cost() {
    double cost = 0;
    graph_.ForEachRelativePose(
        [&](Index e, const G& T) { cost += FactorCost(graph_.FactorOf(e), false, T); });
    return cost;
  }

  CondensedGraph<G> graph_;
  Index edge_ = kNone;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(TrialTest, Groups);

TYPED_TEST(TrialTest, WhatIsTakenBackIsWhatItWas) {
  Hierarchy<TypeParam>& hierarchy = this->graph_.hierarchy();
  this->graph_.SetWorldPose(this->kEdges, this->Aside(1));
  const TypeParam T = hierarchy.RelativePose(0, 0, 1);
  ASSERT_TRUE(hierarchy.Refresh(this->edge_, T));
  hierarchy.TakeRefreshed();
  const double cost = this->Cost();
  const auto measurement = hierarchy.FactorOf(0, this->edge_).term->measurement;
  for (const double distance : {2., 1e4}) {
    hierarchy.TryChains(ChainTrial::kBegin);
    EXPECT_TRUE(hierarchy.Refresh(this->edge_, this->Aside(distance)));
    EXPECT_EQ(this->Lags(), distance > 1e3);
    hierarchy.TryChains(ChainTrial::kPutBack);
    hierarchy.TryChains(ChainTrial::kEnd);
    EXPECT_FALSE(this->Lags());
    EXPECT_EQ(this->Cost(), cost) << distance;
    EXPECT_EQ(hierarchy.FactorOf(0, this->edge_).term->measurement.translation(),
              measurement.translation());
    EXPECT_TRUE(hierarchy.TakeRefreshed().empty());
  }
}

TYPED_TEST(TrialTest, WhatIsNotTakenBackStays) {
  Hierarchy<TypeParam>& hierarchy = this->graph_.hierarchy();
  const auto measurement = [&] {
    return TypeParam(hierarchy.FactorOf(0, this->edge_).term->measurement);
  };
  const TypeParam before = measurement();
  hierarchy.TryChains(ChainTrial::kBegin);
  ASSERT_TRUE(hierarchy.Refresh(this->edge_, this->Aside(2)));
  hierarchy.TryChains(ChainTrial::kEnd);
  EXPECT_GT(measurement().Minus(before).norm(), 1e-3);
  EXPECT_FALSE(hierarchy.TakeRefreshed().empty());
}

// Where a chain is bent far its term says little of what its edges cost; where it hardly bends, the
// edges are not asked.
TYPED_TEST(TrialTest, WhatIsBentFarCostsWhatItsEdgesDo) {
  Hierarchy<TypeParam>& hierarchy = this->graph_.hierarchy();
  const auto of_term = [&](const TypeParam& T) {
    return FactorCost(hierarchy.FactorOf(0, this->edge_), false, T);
  };
  this->graph_.SetWorldPose(this->kEdges, this->Aside(1));
  const TypeParam near = hierarchy.RelativePose(0, 0, 1);
  const std::int64_t visited = this->graph_.visited_edges();
  EXPECT_EQ(hierarchy.CostAt(this->edge_, near), of_term(near));
  EXPECT_EQ(this->graph_.visited_edges(), visited);
  EXPECT_GT(this->Cost(), 1.05 * of_term(near));
  this->graph_.SetWorldPose(this->kEdges, this->Aside(30));
  const TypeParam far = hierarchy.RelativePose(0, 0, 1);
  EXPECT_NEAR(hierarchy.CostAt(this->edge_, far), this->Cost(), 1e-9 * this->Cost());
  EXPECT_EQ(this->graph_.visited_edges(), visited + this->kEdges);
  EXPECT_GT(this->Cost(), 10 * of_term(far));
}

// What begins to lag yields to its ends from where it was, not from where it was linearized long
// before.
TYPED_TEST(TrialTest, WhatBeginsToLagStaysWhereItIs) {
  Hierarchy<TypeParam>& hierarchy = this->graph_.hierarchy();
  hierarchy.Refresh(this->edge_, this->Aside(2));
  this->graph_.SetWorldPose(this->kEdges, this->Aside(100));
  const double cost = this->Cost();
  hierarchy.Refresh(this->edge_, hierarchy.RelativePose(0, 0, 1));
  ASSERT_TRUE(this->Lags());
  EXPECT_NEAR(this->Cost(), cost, 1e-6 * cost);
}

}  // namespace
}  // namespace hpgo
