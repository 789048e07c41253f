#include "hpgo/update/window_step.h"

#include <cmath>
#include <string>

#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "test/solve/small_graphs.h"
#include "test/solve/small_hierarchies.h"

namespace hpgo {
namespace {

constexpr float kPending = 7;
constexpr Index kPendingEdge = 3, kNewEdge = 5;

class WindowStepTest : public testing::Test {
 protected:
  WindowStepTest()
      : hierarchy_(MakeHierarchy(MakeKnownGraph<SE2>(12, 0.05, 1).graph, {})),
        step_(Engine::kBlock, &hierarchy_, [](Index e) { return std::to_string(e); }) {
    for (const Index e : {kPendingEdge, kNewEdge}) {
      hierarchy_.SetPending(0, e, kPending, thresholds_.pending);
    }
  }
  float Pending(Index e) const { return hierarchy_.level(0).edges[e].pending; }
  StepResult Solve(const WindowStep<SE2>::IsKnown& is_known) {
    EXPECT_TRUE(step_.window().BuildWhole(0, &hierarchy_));
    const auto solver = MakeBlockSolver<SE2>();
    return step_.SolveBy(solver.get(), {}, thresholds_, Budget(UpdateLimits()), is_known);
  }

  Hierarchy<SE2> hierarchy_;
  StressThresholds thresholds_ = StressThresholds::FromMean(1, 1e-3);
  WindowStep<SE2> step_;
};

TEST_F(WindowStepTest, ASolveIsDoneWithWhatWasPending) {
  EXPECT_GT(Solve({}).decrease, 0);
  EXPECT_LT(Pending(kPendingEdge), 0.1 * kPending);
  EXPECT_LT(Pending(kNewEdge), 0.1 * kPending);
}

TEST_F(WindowStepTest, AStepThatIsNoMinimumIsNot) {
  EXPECT_GT(Solve([](Index e) { return e != kNewEdge; }).decrease, 0);
  EXPECT_EQ(Pending(kPendingEdge), kPending);
  EXPECT_GT(Pending(kNewEdge), kPending);  // it has changed
}

// Two groups a kilometre apart, with so many edges between them; the edge above them says that they
// are turned. The edges fit, or are `off` metres to the left and to the right by turns. As many as
// `before` tie the first group to one before it, which stays where it is.
class AskBelowTest : public testing::Test {
 protected:
  // Whether a step goes where the edge above says.
  bool Follows(double turn, int edges_between, double off = 0, int before = 0) {
    Hierarchy<SE2> hierarchy = MakeHierarchy(Pairs(edges_between, off, before), {2, 3});
    EXPECT_EQ(hierarchy.num_levels(), 2);
    const Index between = before > 0 ? 1 : 0;
    const LevelEdge& edge = hierarchy.level(1).edges[between];
    EXPECT_EQ(edge.num_children, edges_between);
    const auto angle = [&] {
      return hierarchy.RelativePose(1, edge.node[0], edge.node[1]).angle();
    };
    SE2& measured = hierarchy.mutable_level(1).terms[between].measurement;
    measured = measured * SE2(0, 0, turn);
    WindowStep<SE2> step(Engine::kBlock, &hierarchy, [](Index e) { return std::to_string(e); });
    EXPECT_TRUE(step.window().BuildWhole(1, &hierarchy));
    const double angle_before = angle();
    step.Solve(10, 1e9, thresholds_, Budget(UpdateLimits()));
    is_dirty_ = edge.dirty;
    const double turned = angle() - angle_before;
    EXPECT_TRUE(turned == 0 || std::abs(turned - turn) < 1e-6) << turned;
    return turned != 0;
  }

  StressThresholds thresholds_ = StressThresholds::FromMean(1, 1e-3);
  bool is_dirty_ = false;  // the edge above, after the step

  static void Scale(double factor, ceres_costs::RelativePoseTerm<SE2>* term) {
    term->information =
        ceres_costs::PackedSymmetric<SE2::kDof>(SE2::Matrix(factor * term->information.Dense()));
  }
  static PoseGraph<SE2> Pairs(int edges_between, double off, int before) {
    PoseGraph<SE2> graph;
    const int first = before > 0 ? 2 : 0;
    for (int k = 0; k < first + 4; ++k) {
      (void)graph.AddNode({k, SE2(k / 2 * 1000 + k, 0, 0), false});
    }
    GraphEdge<SE2> edge;
    edge.information = SE2::Matrix::Identity();
    const auto add = [&](int i, int j, double to_the_left = 0) {
      edge.i = i;
      edge.j = j;
      edge.measurement =
          graph.nodes()[i].pose.Between(graph.nodes()[j].pose) * SE2(0, to_the_left, 0);
      (void)graph.AddEdge(edge);
    };
    if (before > 0) add(0, 1);
    for (int k = 0; k < before; ++k) add(1, 2);
    add(first, first + 1);
    for (int k = 0; k < edges_between; ++k) add(first + 1, first + 2, k % 2 == 0 ? off : -off);
    add(first + 2, first + 3);
    return graph;
  }
};

TEST_F(AskBelowTest, AFarTurnIsNotTakenWhereTheEdgesBelowDisagree) {
  EXPECT_FALSE(Follows(0.2, 5));
}

TEST_F(AskBelowTest, ASmallOneIsTakenAsItIs) { EXPECT_TRUE(Follows(0.002, 5)); }

// Small turns add up, and what is below turns with them.
TEST_F(AskBelowTest, WhatHasTurnedIsMergedAgain) {
  thresholds_ = StressThresholds::FromMean(1, 1e-9);
  EXPECT_TRUE(Follows(0.009, 5));
  EXPECT_TRUE(is_dirty_);
  EXPECT_TRUE(Follows(0.0001, 5));
  EXPECT_FALSE(is_dirty_);
}

// What is off below turns as well.
TEST_F(AskBelowTest, ASmallOneIsNotTakenWhereEdgesAreFarOff) {
  EXPECT_FALSE(Follows(0.002, 6, 1000));
}

// Others are not asked, for which there would be no place left.
TEST_F(AskBelowTest, WhatDoesNotTurnIsNotAsked) { EXPECT_FALSE(Follows(0.2, 5, 0, 1998)); }

// Edges that promise too much make doubtful what others say that have not been asked: here one of
// the first group, which is too soft and would have it go aside.
TEST_F(AskBelowTest, OthersAreAskedWhereSomeMissMuch) {
  for (const double promises : {1., 100.}) {
    Hierarchy<SE2> hierarchy = MakeHierarchy(Pairs(5, 0, 5), {2, 3});
    Level<SE2>& level = hierarchy.mutable_level(1);
    level.terms[0].measurement = level.terms[0].measurement * SE2(0, 50, 0);
    Scale(1e-6, &level.terms[0]);
    Scale(promises, &level.terms[1]);
    const Index last = level.edges[1].node[1];
    hierarchy.SetLocalPose(1, last, hierarchy.WorldPose(1, last) * SE2(0, 0, 0.2));
    WindowStep<SE2> step(Engine::kBlock, &hierarchy, [](Index e) { return std::to_string(e); });
    EXPECT_TRUE(step.window().BuildWhole(1, &hierarchy));
    const StepResult result = step.Solve(10, 1e9, thresholds_, Budget(UpdateLimits()));
    EXPECT_EQ(result.decrease > 0, promises == 1);
  }
}

// However many edges there are below: what is asked is bounded.
TEST_F(AskBelowTest, ATurnOfMoreEdgesThanMayBeAskedIsTakenAsItIs) {
  EXPECT_FALSE(Follows(0.2, 1900));
  EXPECT_TRUE(Follows(0.2, 2100));
}

}  // namespace
}  // namespace hpgo
