// How closures that are far off are taken in.

#include "hpgo/update/far_closures.h"

#include "gtest/gtest.h"
#include "hpgo/update/constants.h"
#include "test/update/ladder.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

constexpr int kLength = 201, kNodes = 200;

template <typename G>
class FarClosuresTest : public testing::Test {
 protected:
  FarClosuresTest() : update_(Ladder<G>(kLength)) {}

  CondensedGraph<G>& graph() { return update_.graph(); }
  // Node k of the tail, counted from its end.
  Index Tail(int k) const { return 2 * kLength + kTail - 1 - k; }
  // A closure from a rung to a node, which says that this stands so much elsewhere.
  Index Close(Index i, Index j, const G& off) {
    const G T_i_j = graph().WorldPose(i).Between(graph().WorldPose(j));
    const Index e = graph().AddEdge(i, j, Measuring<G>(T_i_j * off));
    graph().Restructure();
    graph().hierarchy().AssignGroups();
    return e;
  }
  // A closure between the same places, as they are to be in the world.
  Index CloseAlike(Index i, Index j, Index tail, const G& moved) {
    const auto pose = [&](Index n) {
      return n == tail ? moved * graph().WorldPose(n) : graph().WorldPose(n);
    };
    return Close(
        i, j, graph().WorldPose(i).Between(graph().WorldPose(j)).Between(pose(i).Between(pose(j))));
  }
  double Turn(Index e, const G& to) {
    return to.Minus(graph().RelativePose(e)).template tail<G::kRotationDof>().norm();
  }
  double Displacement(Index e, const G& to) {
    return to.Minus(graph().RelativePose(e)).template head<G::kDim>().norm();
  }
  bool IsUnderWay(Index e) { return graph().pulled().count(e) > 0; }
  G Measured(Index e) { return graph().FactorOf(e).term->measurement; }
  // The end of an edge goes a share of the way to where the edge pulls.
  void Follow(Index e, double share) {
    const G from = graph().RelativePose(e), to = graph().PullOf(e);
    const G T = from.Plus(share * to.Minus(from));
    graph().SetWorldPose(graph().End(e, 1), graph().WorldPose(graph().End(e, 0)) * T);
  }

  UpdateFixture<G> update_;
  FarClosures<G> closures_;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(FarClosuresTest, Groups);

TYPED_TEST(FarClosuresTest, WhatIsTurnedFarPullsWithinReach) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(0, 1));
  const G measured = this->Measured(e);
  EXPECT_TRUE(this->closures_.Begin({e}, kNodes, &this->graph()).empty());
  ASSERT_TRUE(this->IsUnderWay(e));
  EXPECT_NEAR(this->Turn(e, this->graph().PullOf(e)), 0.25, 1e-6);  // a fourth of the way
  EXPECT_LT(this->Turn(e, this->graph().PullOf(e)), kTurnOfADegree);
  // To the caller it measures what it did.
  EXPECT_LT(this->Measured(e).Minus(measured).norm(), 1e-12);
  EXPECT_EQ(this->graph().FindInconsistency(), "");
}

TYPED_TEST(FarClosuresTest, WhatIsWithinReachIsTakenInAtOnce) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(5, 0.29));
  EXPECT_TRUE(this->closures_.Begin({e}, kNodes, &this->graph()).empty());
  EXPECT_FALSE(this->IsUnderWay(e));
}

// Twenty metres are far where the map is a hundred metres wide, and ten are not.
TYPED_TEST(FarClosuresTest, HowFarADisplacementIsGoesByTheMapAround) {
  using G = TypeParam;
  const Index near = this->Close(100, this->Tail(0), Ahead<G>(9));
  const Index far = this->Close(100, this->Tail(0), Ahead<G>(25));
  this->closures_.Begin({near, far}, kNodes, &this->graph());
  EXPECT_FALSE(this->IsUnderWay(near));
  ASSERT_TRUE(this->IsUnderWay(far));
  EXPECT_LT(this->Displacement(far, this->graph().PullOf(far)), 13);
}

// Of a window, that is: whose nodes would have to take it up.
TYPED_TEST(FarClosuresTest, TheMapAroundIsThatOfAWindow) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(9));
  this->closures_.Begin({e}, 4, &this->graph());
  EXPECT_TRUE(this->IsUnderWay(e));
}

TYPED_TEST(FarClosuresTest, AllGoOnOnceAllAreNear) {
  using G = TypeParam;
  const Index first = this->Close(100, this->Tail(0), Ahead<G>(0, 1));
  const Index second = this->Close(50, this->Tail(12), Ahead<G>(0, -1));
  this->closures_.Begin({first, second}, kNodes, &this->graph());
  this->closures_.NoteWindows(kMostWindowsOfADegree - 1);
  this->Follow(first, 0.9);
  EXPECT_TRUE(this->closures_.GoOn(false, &this->graph()).empty());
  this->Follow(second, 0.9);
  const std::vector<Index> expected = {first, second};
  EXPECT_EQ(this->closures_.GoOn(false, &this->graph()), expected);
  EXPECT_NEAR(this->Turn(first, this->graph().PullOf(first)), 0.775 / 3, 1e-3);
}

// Until then the levels below the top do not know of it.
TYPED_TEST(FarClosuresTest, EachLevelHasHadAWindowFirst) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(0, 1));
  this->closures_.Begin({e}, kNodes, &this->graph());
  this->Follow(e, 0.9);
  this->closures_.NoteWindows(this->graph().hierarchy().num_levels() - 1);
  EXPECT_TRUE(this->closures_.GoOn(false, &this->graph()).empty());
  this->closures_.NoteWindows(1);
  EXPECT_FALSE(this->closures_.GoOn(false, &this->graph()).empty());
  this->Follow(e, 0.9);
  EXPECT_TRUE(this->closures_.GoOn(false, &this->graph()).empty());  // of the next degree
}

TYPED_TEST(FarClosuresTest, OneThatDoesNotGetThereIsNotWaitedForForEver) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(0, 1));
  this->closures_.Begin({e}, kNodes, &this->graph());
  this->closures_.NoteWindows(kMostWindowsOfADegree - 1);
  EXPECT_TRUE(this->closures_.GoOn(false, &this->graph()).empty());
  this->closures_.NoteWindows(1);
  EXPECT_FALSE(this->closures_.GoOn(false, &this->graph()).empty());
  EXPECT_FALSE(this->closures_.GoOn(true, &this->graph()).empty());  // nor at rest
}

// Though the map does not follow at all.
TYPED_TEST(FarClosuresTest, ItEnds) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(0, 3));
  const G measured = this->Measured(e);
  this->closures_.Begin({e}, kNodes, &this->graph());
  int degrees = 1;
  while (!this->closures_.GoOn(true, &this->graph()).empty()) ++degrees;
  EXPECT_EQ(degrees, kMostDegrees);
  EXPECT_FALSE(this->IsUnderWay(e));
  EXPECT_LT(this->graph().PullOf(e).Minus(measured).norm(), 1e-12);
}

// It measures the same displacement: a degree ahead it would hold the first one.
TYPED_TEST(FarClosuresTest, ANeighbourBeginsWhereOthersAre) {
  using G = TypeParam;
  const Index tail = this->Tail(0);
  const G moved = Ahead<G>(3, 1);
  const Index first = this->CloseAlike(100, tail, tail, moved);
  this->closures_.Begin({first}, kNodes, &this->graph());
  this->Follow(first, 0.9);
  const G pull = this->graph().PullOf(first);
  const G left = this->graph().WorldPose(100) * this->Measured(first) * pull.Inverse() *
                 this->graph().WorldPose(100).Inverse();
  for (const bool reversed : {false, true}) {
    const Index i = reversed ? tail : 90, j = reversed ? 90 : tail;
    // Where the first one pulls, and then all that is left of its way.
    const G there = this->graph().WorldPose(100) * pull * this->graph().WorldPose(tail).Inverse();
    const Index e = this->CloseAlike(i, j, tail, left * there);
    EXPECT_TRUE(this->closures_.Begin({e}, kNodes, &this->graph()).empty());
    ASSERT_TRUE(this->IsUnderWay(e));
    const G X_tail = there * this->graph().WorldPose(tail), X_rung = this->graph().WorldPose(90);
    const G expected = reversed ? X_tail.Between(X_rung) : X_rung.Between(X_tail);
    // As seen from a tail that is not there yet, it is the same up to that.
    EXPECT_LT(this->graph().PullOf(e).Minus(expected).norm(), reversed ? 0.3 : 1e-6);
  }
}

// Else they would hold each other: a degree from where they are fits.
TYPED_TEST(FarClosuresTest, WhereOneIsElsewhereAllBeginAgainFromWhereTheyAre) {
  using G = TypeParam;
  const Index first = this->Close(100, this->Tail(0), Ahead<G>(0, 3));
  this->closures_.Begin({first}, kNodes, &this->graph());
  this->Follow(first, -2);
  EXPECT_GT(this->Turn(first, this->graph().PullOf(first)), 0.5);
  const Index second = this->Close(50, this->Tail(0), Ahead<G>(0, -2));
  EXPECT_EQ(this->closures_.Begin({second}, kNodes, &this->graph()), std::vector<Index>{first});
  for (const Index e : {first, second}) {
    EXPECT_LE(this->Turn(e, this->graph().PullOf(e)), kTurnOfADegree);
  }
}

TYPED_TEST(FarClosuresTest, AllPullToWhatTheyMeasureWhereAsked) {
  using G = TypeParam;
  const Index e = this->Close(100, this->Tail(0), Ahead<G>(0, 3));
  this->closures_.Begin({e}, kNodes, &this->graph());
  EXPECT_EQ(FarClosures<G>::EndAll(&this->graph()), std::vector<Index>{e});
  EXPECT_FALSE(this->IsUnderWay(e));
  EXPECT_LT(this->graph().PullOf(e).Minus(this->Measured(e)).norm(), 1e-12);
}

}  // namespace
}  // namespace hpgo
