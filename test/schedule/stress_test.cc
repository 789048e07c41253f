#include "hpgo/schedule/stress.h"

#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

using ceres_costs::FactorTerm;

template <typename G>
class StressTest : public testing::Test {
 protected:
  // A walk of 30 nodes with closures, and a prior, on several levels, every edge merged.
  StressTest() : hierarchy_({/*max_group_size=*/3, /*max_top_nodes=*/5}) {
    const KnownGraph<G> known = MakeKnownGraph<G>(30, 0.02, 2);
    std::mt19937_64 rng(1);
    for (const G& pose : known.truth) hierarchy_.AddNode(pose * RandomPose<G>(&rng, 0.02, 0.02));
    for (const GraphEdge<G>& edge : known.graph.edges()) {
      AddEdge(edge.i, edge.j, edge.measurement, edge.information);
    }
    AddEdge(kNone, 7, known.truth[7], RandomInformation<G>(&rng));
    hierarchy_.AssignGroups();
    for (int l = 1; l < hierarchy_.num_levels(); ++l) {
      for (Index e = 0; e < NumEdges(l); ++e) hierarchy_.Merge(l, e);
    }
    thresholds_.tau = 1e-4;
    thresholds_.pending = thresholds_.dirty = 0.005f;
  }
  void AddEdge(Index i, Index j, const G& measurement, const typename G::Matrix& information) {
    EdgeData<G> data;
    data.term.measurement = measurement;
    data.term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
    data.weight = i == kNone ? 0 : ModularityWeight(data.term);
    hierarchy_.AddEdge(i, j, data);
  }
  Index NumEdges(int l) { return static_cast<Index>(hierarchy_.level(l).edges.size()); }
  const LevelEdge& Edge(int l, Index e) { return hierarchy_.level(l).edges[e]; }

  // The cost of the edges at a node that stands at X.
  double CostAt(int l, Index node, const G& X) {
    double cost = 0;
    ForEachEdge(hierarchy_.level(l), node, [&](Index e, Index other) {
      const G Y = other == kNone ? X : hierarchy_.WorldPose(l, other).Between(X);
      const bool second = Edge(l, e).node[1] == node;
      cost += FactorCost(hierarchy_.FactorOf(l, e), other == kNone, second ? Y : Y.Inverse());
    });
    return cost;
  }

  Hierarchy<G> hierarchy_;
  StressThresholds thresholds_;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(StressTest, Groups);

// The minimum of the quadratic model, from numeric derivatives of the cost.
TYPED_TEST(StressTest, IsThePredictedDecrease) {
  using Tangent = typename TypeParam::Tangent;
  using Hessian = typename TypeParam::Matrix;
  constexpr int D = TypeParam::kDof;
  constexpr double h = 1e-4;
  for (int l = 0; l < this->hierarchy_.num_levels(); ++l) {
    for (Index n = 0; n < this->hierarchy_.level(l).num_nodes; ++n) {
      const TypeParam X = this->hierarchy_.WorldPose(l, n);
      const auto cost = [&](int a, double step_a, int b, double step_b) {
        Tangent d = Tangent::Zero();
        d(a) += step_a;
        d(b) += step_b;
        return this->CostAt(l, n, X.Retract(d));
      };
      Tangent g;
      Hessian H;
      for (int a = 0; a < D; ++a) {
        g(a) = (cost(a, h, a, 0) - cost(a, -h, a, 0)) / (4 * h);
        for (int b = 0; b < D; ++b) {
          H(a, b) =
              (cost(a, h, b, h) - cost(a, h, b, -h) - cost(a, -h, b, h) + cost(a, -h, b, -h)) /
              (8 * h * h);
        }
      }
      const double expected = g.dot(H.ldlt().solve(g));
      const double stress = NodeStress(l, n, 1000, &this->hierarchy_);
      // H holds the residuals' curvature, the stress does not.
      EXPECT_NEAR(stress, expected, 1e-7 + 0.15 * expected) << "level " << l << ", node " << n;
    }
  }
}

TYPED_TEST(StressTest, AConstantNodeIsUnderNone) {
  EXPECT_GT(NodeStress(0, 7, 1000, &this->hierarchy_), 0);
  this->hierarchy_.SetFixed(7, true);
  EXPECT_EQ(NodeStress(0, 7, 1000, &this->hierarchy_), 0);
  EXPECT_EQ(NodeStress(1, this->hierarchy_.Ancestor(7, 1), 1000, &this->hierarchy_), 0);
}

TYPED_TEST(StressTest, LooksAtNoMoreEdgesThanAllowed) {
  EXPECT_EQ(NodeStress(0, 7, 0, &this->hierarchy_), 0);
}

TYPED_TEST(StressTest, HandingDownKeepsTheSumOfSquares) {
  for (int l = 1; l < this->hierarchy_.num_levels(); ++l) {
    for (Index e = 0; e < this->NumEdges(l); ++e) {
      HandDown(l, e, 3, this->thresholds_, &this->hierarchy_);
      double sum = 0;
      for (Index c = this->Edge(l, e).first_child; c != kNone;
           c = this->Edge(l - 1, c).next_sibling) {
        sum += std::pow(this->Edge(l - 1, c).pending, 2);
        this->hierarchy_.SetPending(l - 1, c, 0, this->thresholds_.pending);
      }
      EXPECT_NEAR(sum, 9, 1e-5) << "level " << l << ", edge " << e;
    }
  }
}

TYPED_TEST(StressTest, TheParentIsMergedWhenChangesAddUp) {
  Index child = 0;
  while (this->Edge(0, child).parent == kNone) ++child;
  const Index parent = this->Edge(0, child).parent;
  Level<TypeParam>& above = this->hierarchy_.mutable_level(1);
  for (const Index e : above.dirty) above.edges[e].dirty = false;
  above.dirty.clear();
  TellParent(0, child, 0.003, this->thresholds_, &this->hierarchy_);
  EXPECT_FALSE(above.edges[parent].dirty);
  TellParent(0, child, 0.003, this->thresholds_, &this->hierarchy_);
  EXPECT_TRUE(above.edges[parent].dirty);
  EXPECT_EQ(above.dirty, std::vector<Index>{parent});
}

TYPED_TEST(StressTest, WorkIsFoundAtTheLargestPendingFirst) {
  AddPending(0, 3, 0.1, this->thresholds_, &this->hierarchy_);
  AddPending(0, 9, 5, this->thresholds_, &this->hierarchy_);
  EXPECT_EQ(LargestPending(0, this->hierarchy_), 5);
  const FoundWork work = FindWork(0, 16, 1000, this->thresholds_, &this->hierarchy_);
  EXPECT_TRUE(work.found);
  const Index first = this->Edge(0, 9).node[0];
  EXPECT_EQ(work.examined, 1 + this->hierarchy_.level(0).nodes[first].degree);
  EXPECT_EQ(work.ends[0], this->Edge(0, 9).node[0]);
  EXPECT_EQ(work.ends[1], this->Edge(0, 9).node[1]);
  EXPECT_EQ(this->Edge(0, 9).pending, 0);  // done with
  EXPECT_FLOAT_EQ(LargestPending(0, this->hierarchy_), 0.1f);
}

TYPED_TEST(StressTest, TheSearchIsCappedAndEndsBelowTheThreshold) {
  this->thresholds_.tau = 1e9;  // nothing is worth it
  for (Index e = 0; e < 10; ++e) {
    AddPending(0, e, e < 8 ? 1 : 0.004, this->thresholds_, &this->hierarchy_);
  }
  FoundWork work = FindWork(0, 5, 1000, this->thresholds_, &this->hierarchy_);
  EXPECT_FALSE(work.found);
  EXPECT_GE(work.examined, 5);
  EXPECT_EQ(LargestPending(0, this->hierarchy_), 1);
  work = FindWork(0, 1000, 1000, this->thresholds_, &this->hierarchy_);
  EXPECT_GT(work.examined, 0);
  EXPECT_EQ(LargestPending(0, this->hierarchy_), 0);
  EXPECT_FLOAT_EQ(this->Edge(0, 9).pending, 0.004f);  // remembered, not looked at
}

TYPED_TEST(StressTest, PendingThatTheThresholdHasOvertakenIsLeftAlone) {
  AddPending(0, 3, 0.1, this->thresholds_, &this->hierarchy_);
  this->thresholds_.pending = 0.2f;
  EXPECT_EQ(FindWork(0, 16, 1000, this->thresholds_, &this->hierarchy_).examined, 0);
}

TEST(StressThresholdsTest, FollowTheMean) {
  const StressThresholds thresholds = StressThresholds::FromMean(4, 1e-2);
  EXPECT_DOUBLE_EQ(thresholds.tau, 0.04);
  EXPECT_FLOAT_EQ(thresholds.pending, 0.1f);
  EXPECT_FLOAT_EQ(thresholds.dirty, 0.1f);
  EXPECT_GT(StressThresholds::FromMean(0, 1e-2).tau, 0);
  EXPECT_GT(StressThresholds::FromMean(-1, 1e-2).tau, 0);
}

// The paper's condensed edges are measurements, which a step of everything does not change.
TEST(StressThresholdsTest, OnlyGalerkinEdgesAreAllMergedAnew) {
  const StressThresholds usual = StressThresholds::FromMean(1, 1e-3);
  ASSERT_GT(usual.dirty, 0);
  EXPECT_EQ(usual.MergingAll(CoarseEdges::kGalerkin).dirty, 0);
  EXPECT_EQ(usual.MergingAll(CoarseEdges::kCondensed).dirty, usual.dirty);
}

}  // namespace
}  // namespace hpgo
