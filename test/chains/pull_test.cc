// Edges that pull a part of the way to what they measure.

#include <memory>

#include "ceres/loss_function.h"
#include "gtest/gtest.h"
#include "hpgo/chains/condensed_graph.h"
#include "test/update/ladder.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

template <typename G>
class PullTest : public testing::Test {
 protected:
  PullTest() : graph_(HierarchyOptions(), true) {
    const PoseGraph<G> ladder = Ladder<G>(21);
    for (const GraphNode<G>& node : ladder.nodes()) graph_.AddNode(node.pose);
    graph_.SetHeld(0, true);
    for (const GraphEdge<G>& edge : ladder.edges()) {
      last_ = graph_.AddEdge(edge.i, edge.j, Measuring(edge.measurement));
    }
    graph_.Restructure();
  }
  const G& OnLevel() {
    return graph_.hierarchy().FactorOf(0, graph_.LevelEdgeOf(last_)).term->measurement;
  }
  double Weight() { return graph_.hierarchy().level(0).edges[graph_.LevelEdgeOf(last_)].weight; }
  const G& Measured() { return graph_.FactorOf(last_).term->measurement; }

  CondensedGraph<G> graph_;
  Index last_ = kNone;  // a rung
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(PullTest, Groups);

TYPED_TEST(PullTest, Level0PullsAndTheCallerSeesTheMeasurement) {
  using G = TypeParam;
  const G measured = this->Measured(), first = Ahead<G>(1), second = Ahead<G>(2);
  for (const G& pull : {first, second}) {
    this->graph_.PullTowards(this->last_, pull, {3, 1});
    EXPECT_EQ(this->OnLevel().Minus(pull).norm(), 0);
    EXPECT_EQ(this->graph_.PullOf(this->last_).Minus(pull).norm(), 0);
    EXPECT_EQ(this->Measured().Minus(measured).norm(), 0);
    EXPECT_EQ(this->graph_.FindInconsistency(), "");
  }
  this->graph_.EndPull(this->last_);
  EXPECT_EQ(this->OnLevel().Minus(measured).norm(), 0);
  EXPECT_TRUE(this->graph_.pulled().empty());
}

// It may be one that is turned so far that it holds no group together.
TYPED_TEST(PullTest, GroupsDoNotSeeIt) {
  using G = TypeParam;
  this->last_ = this->graph_.AddEdge(3, 15, Measuring(Ahead<G>(0, 3)));
  this->graph_.Restructure();
  ASSERT_EQ(this->Weight(), 0);
  this->graph_.PullTowards(this->last_, Ahead<G>(1), {3, 1});
  EXPECT_EQ(this->Weight(), 0);
  this->graph_.EndPull(this->last_);
  EXPECT_EQ(this->Weight(), 0);
}

TYPED_TEST(PullTest, OneThatIsRemovedIsForgotten) {
  using G = TypeParam;
  this->graph_.PullTowards(this->last_, Ahead<G>(1), {3, 1});
  this->graph_.RemoveEdge(this->last_);
  EXPECT_TRUE(this->graph_.pulled().empty());
  this->graph_.Restructure();
  EXPECT_EQ(this->graph_.FindInconsistency(), "");
}

TYPED_TEST(PullTest, AnotherMeasurementIsThatAtOnce) {
  using G = TypeParam;
  this->graph_.PullTowards(this->last_, Ahead<G>(1), {3, 1});
  this->graph_.UpdateEdge(this->last_, Measuring(Ahead<G>(5)).term);
  EXPECT_TRUE(this->graph_.pulled().empty());
  EXPECT_EQ(this->Measured().Minus(Ahead<G>(5)).norm(), 0);
}

TYPED_TEST(PullTest, OneWithALossMeasuresWhatItDid) {
  using G = TypeParam;
  const G measured = this->Measured();
  this->graph_.PullTowards(this->last_, Ahead<G>(1), {3, 1});
  this->graph_.SetLoss(this->last_, std::make_shared<ceres::HuberLoss>(1.));
  EXPECT_TRUE(this->graph_.pulled().empty());
  EXPECT_EQ(this->OnLevel().Minus(measured).norm(), 0);
  EXPECT_FALSE(this->graph_.CanBePulled(this->last_));
}

// What has no place on level 0 has none to pull from, and where a direction is not measured there
// is no way to go.
TYPED_TEST(PullTest, OnlyClosuresCanBePulled) {
  using G = TypeParam;
  EXPECT_TRUE(this->graph_.CanBePulled(this->last_));
  EXPECT_FALSE(this->graph_.CanBePulled(1));  // of a chain
  EdgeData<G> flat = Measuring(Ahead<G>(1));
  typename G::Matrix information = 1e4 * G::Matrix::Identity();
  information(1, 1) = 0;
  flat.term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
  const Index partial = this->graph_.AddEdge(3, 15, flat);
  const Index prior = this->graph_.AddEdge(kNone, 15, Measuring(Ahead<G>(1)));
  EXPECT_FALSE(this->graph_.CanBePulled(prior));
  this->graph_.Restructure();
  EXPECT_FALSE(this->graph_.CanBePulled(partial));
  for (const int n : {1, 2}) this->graph_.SetHeld(n, true);
  this->graph_.Restructure();
  EXPECT_NE(this->graph_.LevelEdgeOf(1), kNone);
  EXPECT_FALSE(this->graph_.CanBePulled(1));  // closes no loop
  EXPECT_FALSE(this->graph_.CanBePulled(prior));
}

}  // namespace
}  // namespace hpgo
