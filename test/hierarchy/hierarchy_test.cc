#include "hpgo/hierarchy/hierarchy.h"

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/hierarchy/consistency.h"
#include "test/hierarchy/hierarchy_fixture.h"
#include "test/hierarchy/level_cost.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
class HierarchyTest : public HierarchyFixture<G> {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(HierarchyTest, Groups);

TYPED_TEST(HierarchyTest, IsConsistentAfterEveryInsertion) {
  HierarchyOptions options;
  options.max_top_nodes = 12;
  Hierarchy<TypeParam> hierarchy(options);
  for (int k = 0; k < 200; ++k) {
    this->Grow(&hierarchy, 1, 0.6);
    ASSERT_EQ(FindInconsistency(hierarchy), "") << "after node " << k;
  }
  EXPECT_GE(hierarchy.num_levels(), 3);
}

TYPED_TEST(HierarchyTest, ReducesAlmostThreefold) {
  Hierarchy<TypeParam> hierarchy;
  this->Grow(&hierarchy, 5000, 0.3);
  for (int l = 0; l + 2 < hierarchy.num_levels(); ++l) {
    const double ratio =
        static_cast<double>(hierarchy.level(l).num_nodes) / hierarchy.level(l + 1).num_nodes;
    EXPECT_GT(ratio, 2.7) << l;
    EXPECT_LE(ratio, 3.0) << l;
  }
}

TYPED_TEST(HierarchyTest, ATopOfManyEdgesGetsALevelAboveIt) {
  HierarchyOptions options;
  options.max_top_edges = 30;
  Hierarchy<TypeParam> hierarchy(options);
  for (int k = 0; k < 100; ++k) {
    this->Grow(&hierarchy, 1, 2);
    ASSERT_EQ(FindInconsistency(hierarchy), "") << "after node " << k;
    // A top that grouping does not shrink is tried again after it has grown by an eighth.
    ASSERT_LE(hierarchy.level(hierarchy.num_levels() - 1).num_edges, 45) << k;
  }
  EXPECT_GE(hierarchy.num_levels(), 3);
  while (this->nodes_.size() > 5) {
    hierarchy.RemoveNode(this->nodes_.back());
    this->nodes_.pop_back();
  }
  EXPECT_EQ(FindInconsistency(hierarchy), "");
  EXPECT_EQ(hierarchy.num_levels(), 1);
}

TYPED_TEST(HierarchyTest, KeepsWorldPosesThroughGrouping) {
  HierarchyOptions options;
  options.max_top_nodes = 5;
  Hierarchy<TypeParam> hierarchy(options);
  std::vector<TypeParam> poses;
  std::vector<Index> nodes;
  TypeParam pose;
  for (int k = 0; k < 60; ++k) {
    nodes.push_back(hierarchy.AddNode(pose));
    if (k > 0) hierarchy.AddEdge(nodes[k - 1], nodes[k], this->RandomEdge());
    hierarchy.AssignGroups();
    poses.push_back(pose);
    pose = pose * this->RandomPose(1);
  }
  for (int k = 0; k < 60; ++k) {
    EXPECT_LT(poses[k].LocalCoordinates(hierarchy.WorldPose(0, nodes[k])).norm(), 1e-9) << k;
  }
}

TYPED_TEST(HierarchyTest, SurvivesRandomRemovals) {
  for (int seed = 0; seed < 20; ++seed) {
    this->rng_.seed(seed);
    this->nodes_.clear();
    this->edges_.clear();
    HierarchyOptions options;
    options.max_top_nodes = 6;
    Hierarchy<TypeParam> hierarchy(options);
    this->Grow(&hierarchy, 60, 0.7);
    std::uniform_int_distribution<int> choice(0, 3);
    for (int step = 0; step < 80; ++step) {
      std::vector<Index> alive;
      for (Index n = 0; n < static_cast<Index>(hierarchy.level(0).nodes.size()); ++n) {
        if (hierarchy.level(0).nodes[n].alive) alive.push_back(n);
      }
      std::vector<Index> alive_edges;
      for (Index e = 0; e < static_cast<Index>(hierarchy.level(0).edges.size()); ++e) {
        if (hierarchy.level(0).edges[e].alive) alive_edges.push_back(e);
      }
      if (alive.size() < 3) break;
      const auto pick = [&](const std::vector<Index>& from) {
        return from[std::uniform_int_distribution<std::size_t>(0, from.size() - 1)(this->rng_)];
      };
      const int action = choice(this->rng_);
      if (action == 0) {
        hierarchy.RemoveNode(pick(alive));
      } else if (action == 1 && !alive_edges.empty()) {
        hierarchy.RemoveEdge(pick(alive_edges));
      } else if (action == 2) {
        const Index a = pick(alive), b = pick(alive);
        if (a != b) hierarchy.AddEdge(a, b, this->RandomEdge());
        hierarchy.AddEdge(kNone, a, this->RandomEdge());
      } else {
        hierarchy.SetFixed(pick(alive), step % 2 == 0);
      }
      hierarchy.AssignGroups();
      ASSERT_EQ(FindInconsistency(hierarchy), "")
          << "seed " << seed << " step " << step << " action " << action;
    }
  }
}

// The change of the objective under a small correction of one group equals that of the coarse
// edges.
TYPED_TEST(HierarchyTest, GalerkinEdgesMatchTheFineObjective) {
  using Tangent = typename TypeParam::Tangent;
  HierarchyOptions options;
  options.max_top_nodes = 8;
  Hierarchy<TypeParam> hierarchy(options);
  this->Grow(&hierarchy, 60, 0.7);
  hierarchy.AddEdge(kNone, this->nodes_[5],
                    this->RandomEdge(hierarchy.WorldPose(0, this->nodes_[5])));
  this->MergeAll(&hierarchy);
  ASSERT_GE(hierarchy.num_levels(), 3);
  const auto cost = [&](int l) { return CostOfLevel(hierarchy, l); };
  const int top = hierarchy.num_levels() - 1;
  for (Index n = 0; n < static_cast<Index>(hierarchy.level(top).nodes.size()); ++n) {
    if (!hierarchy.level(top).nodes[n].alive) continue;
    for (int k = 0; k < TypeParam::kDof; ++k) {
      const TypeParam before = hierarchy.WorldPose(top, n);
      double fine[3], coarse[3];
      const double h = 1e-3;
      for (int s = -1; s <= 1; ++s) {
        Tangent d = Tangent::Zero();
        d(k) = s * h;
        hierarchy.SetWorldPose(top, n, before.Retract(d));
        fine[s + 1] = cost(0);
        coarse[s + 1] = cost(top);
      }
      hierarchy.SetWorldPose(top, n, before);
      const double fine_gradient = (fine[2] - fine[0]) / (2 * h);
      const double coarse_gradient = (coarse[2] - coarse[0]) / (2 * h);
      EXPECT_NEAR(fine_gradient, coarse_gradient, 2e-3 * (1 + std::abs(fine_gradient)));
    }
  }
}

TYPED_TEST(HierarchyTest, CostDecreaseIsThatOfTheGraphWithinItsBudget) {
  HierarchyOptions options;
  options.max_top_nodes = 8;
  Hierarchy<TypeParam> hierarchy(options);
  this->Grow(&hierarchy, 60, 0.7);
  hierarchy.AddEdge(kNone, this->nodes_[5], this->RandomEdge());
  this->MergeAll(&hierarchy);
  const int l = hierarchy.num_levels() - 1;
  ASSERT_GE(l, 2);
  // The edges of level 0 that one of level k stands for.
  const std::function<void(int, Index, std::vector<Index>*)> collect =
      [&](int k, Index edge, std::vector<Index>* found) {
        if (k == 0) found->push_back(edge);
        if (k == 0) return;
        for (Index c = hierarchy.level(k).edges[edge].first_child; c != kNone;) {
          collect(k - 1, c, found);
          c = hierarchy.level(k - 1).edges[c].next_sibling;
        }
      };
  const auto cost = [&](int k, const std::vector<Index>& edges) {
    double sum = 0;
    for (const Index e : edges) {
      const LevelEdge& edge = hierarchy.level(k).edges[e];
      sum += FactorCost(hierarchy.FactorOf(k, e), edge.node[0] == kNone,
                        hierarchy.RelativePose(k, edge.node[0], edge.node[1]));
    }
    return sum;
  };
  const Level<TypeParam>& level = hierarchy.level(l);
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    std::vector<Index> fine;
    collect(l, e, &fine);
    const Index g = level.edges[e].node[0], h = level.edges[e].node[1];
    const TypeParam T_world_h = hierarchy.WorldPose(l, h), before = hierarchy.RelativePose(l, g, h);
    double in_graph = cost(0, fine), in_level = cost(l, {e});
    EXPECT_NEAR(level.edges[e].chi2, in_graph, 1e-5 * in_graph);
    hierarchy.SetWorldPose(l, h, T_world_h * this->RandomPose(0.5));
    const TypeParam after = hierarchy.RelativePose(l, g, h);
    in_graph -= cost(0, fine);
    in_level -= cost(l, {e});
    hierarchy.SetWorldPose(l, h, T_world_h);
    int budget = 1000, none = 0;
    EXPECT_NEAR(hierarchy.CostDecrease(l, e, before, after, &budget), in_graph,
                1e-9 * (1 + std::abs(in_graph)));
    EXPECT_LE(budget, 1000 - static_cast<int>(fine.size()));
    EXPECT_NEAR(hierarchy.CostDecrease(l, e, before, after, &none), in_level,
                1e-9 * (1 + std::abs(in_level)));
    EXPECT_EQ(none, 0);
  }
}

// What its term says is not all that it costs.
TYPED_TEST(HierarchyTest, TheKeeperOfAChainIsAsked) {
  Hierarchy<TypeParam> hierarchy;
  this->Grow(&hierarchy, 2, 0);
  const Index edge = this->edges_.front();
  hierarchy.mutable_level(0).edges[edge].condensed = true;
  double cost = 0;
  hierarchy.SetChains({nullptr, [&](Index, const TypeParam&) { return cost += 1; }, nullptr});
  const TypeParam T;
  EXPECT_EQ(hierarchy.CostAt(edge, T), 1);
  int none = 0;
  EXPECT_EQ(hierarchy.CostDecrease(0, edge, T, T, &none), 2 - 3);
}

TYPED_TEST(HierarchyTest, CondensedEdgesAreExactWhereMeasurementsAgree) {
  // With measurements that agree with the poses, both kinds say the same: the current estimate.
  HierarchyOptions options;
  options.max_top_nodes = 8;
  for (const CoarseEdges kind : {CoarseEdges::kGalerkin, CoarseEdges::kCondensed}) {
    options.coarse_edges = kind;
    Hierarchy<TypeParam> hierarchy(options);
    std::vector<TypeParam> poses;
    for (int k = 0; k < 60; ++k) {
      poses.push_back(k == 0 ? TypeParam() : poses.back() * this->RandomPose(1));
      hierarchy.AddNode(poses[k]);
      for (const int other : {k - 1, k - 7}) {
        if (other < 0) continue;
        EdgeData<TypeParam> data = this->RandomEdge();
        data.term.measurement = poses[other].Between(poses[k]);
        hierarchy.AddEdge(other, k, data);
      }
      hierarchy.AssignGroups();
    }
    this->MergeAll(&hierarchy);
    for (int l = 1; l < hierarchy.num_levels(); ++l) {
      const Level<TypeParam>& level = hierarchy.level(l);
      for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
        if (!level.edges[e].alive) continue;
        const TypeParam T =
            hierarchy.RelativePose(l, level.edges[e].node[0], level.edges[e].node[1]);
        EXPECT_LT(T.LocalCoordinates(level.terms[e].measurement).norm(), 1e-6);
      }
    }
  }
}

TYPED_TEST(HierarchyTest, GivesTheSameBitsForTheSameCalls) {
  TypeParam last[2];
  for (int run = 0; run < 2; ++run) {
    this->rng_.seed(3);
    this->nodes_.clear();
    std::srand(5);  // Eigen's Random
    Hierarchy<TypeParam> hierarchy;
    this->Grow(&hierarchy, 1000, 0.4);
    this->MergeAll(&hierarchy);
    last[run] = hierarchy.level(hierarchy.num_levels() - 1).terms[0].measurement;
  }
  for (int k = 0; k < TypeParam::kParams; ++k) EXPECT_EQ(last[0].data()[k], last[1].data()[k]);
}

}  // namespace
}  // namespace hpgo
