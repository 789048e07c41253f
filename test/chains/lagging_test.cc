// Chains that could not follow their ends: until they are cut they move nothing that nobody sees.

#include <algorithm>
#include <vector>

#include "ceres_costs/factor_term.h"
#include "gtest/gtest.h"
#include "hpgo/chains/condensed_graph.h"
#include "test/update/ladder.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// Two chains of 64 edges ahead, one after the other, between three nodes that are held. The end of
// the second one is moved.
template <typename G>
class LaggingTest : public testing::Test {
 protected:
  static constexpr int kMiddle = 64, kEnd = 128;
  LaggingTest() : graph_(HierarchyOptions(), true) {
    graph_.AddNode(G());
    for (int k = 1; k <= kEnd; ++k) {
      graph_.AddNode(At(k, 0));
      graph_.AddEdge(k - 1, k, Measuring(At(1, 0)));
    }
    graph_.SetTolerance(1e-3);
    for (const int k : {0, kMiddle, kEnd}) graph_.SetHeld(k, true);
    graph_.Restructure();
  }
  static G At(double ahead, double aside) {
    typename G::Tangent d = G::Tangent::Zero();
    d(0) = ahead;
    d(1) = aside;
    return G().Plus(d);
  }
  // Of the ends of the second chain, with the last one pulled so far from where it was.
  static G Pulled(double ahead, double aside) { return At(kEnd - kMiddle + ahead, aside); }
  void Pull(double ahead, double aside) {
    graph_.SetWorldPose(kEnd, graph_.WorldPose(kMiddle) * Pulled(ahead, aside));
  }
  // As where a solve has the ends of the second chain.
  void Refresh(const G& T) { graph_.hierarchy().Refresh(graph_.LevelEdgeOf(kMiddle), T); }
  // Of the chain that an edge is in.
  bool Lags(Index edge) const {
    return graph_.hierarchy().level(0).edges[graph_.LevelEdgeOf(edge)].lags;
  }
  double Cost() {
    double cost = 0;
    graph_.ForEachRelativePose(
        [&](Index e, const G& T) { cost += FactorCost(graph_.FactorOf(e), false, T); });
    return cost;
  }
  // How far the node is that is furthest off from what a client knows of it, in m and rad.
  double FurthestOff(const std::vector<G>& known) {
    double furthest = 0;
    graph_.ForEachPose([&](Index n, const G& pose) {
      furthest = std::max(furthest, known[n].LocalCoordinates(pose).norm());
    });
    return furthest;
  }

  CondensedGraph<G> graph_;
};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(LaggingTest, Groups);

// Where it is, and where its ends have moved on: steps that begin anew may end anywhere.
TYPED_TEST(LaggingTest, SettlingAllOfItDoesNotRaiseItsCost) {
  this->Refresh(this->Pulled(0, 2));
  for (const double aside : {40., 45.}) {
    this->Pull(0, aside);
    this->Refresh(this->Pulled(0, aside));
    ASSERT_TRUE(this->Lags(this->kMiddle));
    const double cost = this->Cost();
    this->graph_.SettleAll();
    EXPECT_TRUE(this->Lags(this->kMiddle)) << aside;
    EXPECT_LE(this->Cost(), 1.001 * cost) << aside;
  }
}

// Its inside yields to its ends as long as it lags, and else is where its edges prefer it: another
// place, though its ends rest.
TYPED_TEST(LaggingTest, WhatJumpsWhereItBeginsOrCeasesToLagIsVisited) {
  constexpr double kLimit = 0.01;  // m, and rad
  std::vector<TypeParam> known(this->kEnd + 1);
  const auto look = [&] {
    this->graph_.ForEachMoved(kLimit, kLimit,
                              [&](Index n, const TypeParam& pose) { known[n] = pose; });
  };
  this->Pull(0, 2);
  this->Refresh(this->Pulled(0, 2));
  look();
  for (const double aside : {100., 2.}) {
    this->Refresh(this->Pulled(0, aside));
    ASSERT_EQ(this->Lags(this->kMiddle), aside > 2);
    ASSERT_GT(this->FurthestOff(known), 10) << aside;
    look();
    EXPECT_LT(this->FurthestOff(known), 2 * kLimit) << aside;
  }
}

// It rests nowhere, though it is linearized where its ends are: taken for one that does, it would
// go where a step raises its cost.
TYPED_TEST(LaggingTest, WhatIsJoinedToItLagsWithIt) {
  this->Refresh(this->Pulled(0, 2));
  this->Pull(20, 0);
  this->Refresh(this->Pulled(20, 0));
  ASSERT_TRUE(this->Lags(this->kMiddle));
  const double cost = this->Cost();
  this->graph_.SetHeld(this->kMiddle, false);
  this->graph_.Restructure();
  ASSERT_FALSE(this->graph_.IsKept(this->kMiddle));
  EXPECT_TRUE(this->Lags(0));
  EXPECT_LE(this->Cost(), 1.001 * cost);
}

}  // namespace
}  // namespace hpgo
