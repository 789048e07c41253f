#include "hpgo/solve/window.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <random>
#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "small_graphs.h"
#include "small_hierarchies.h"
#include "small_problems.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

constexpr WindowLimits kUnlimited = {1000000, 1000000};

template <typename G>
class WindowTest : public testing::Test {
 protected:
  // Nodes 0 to n - 1 with noisy edges between `pairs`.
  Hierarchy<G> Make(int n, const std::vector<std::pair<int, int>>& pairs,
                    const std::set<int>& fixed = {}, const HierarchyOptions& options = {}) {
    PoseGraph<G> graph;
    for (int k = 0; k < n; ++k) {
      GraphNode<G> node;
      node.id = k;
      node.pose = RandomPose<G>(&rng_, 5, 2);
      node.fixed = fixed.count(k) > 0;
      EXPECT_TRUE(graph.AddNode(node).ok());
    }
    for (const auto& [i, j] : pairs) {
      GraphEdge<G> edge;
      edge.i = i;
      edge.j = j;
      edge.measurement =
          graph.nodes()[i].pose.Between(graph.nodes()[j].pose) * RandomPose<G>(&rng_, 0.05, 0.05);
      edge.information = RandomInformation<G>(&rng_);
      EXPECT_TRUE(graph.AddEdge(edge).ok());
    }
    return MakeHierarchy(graph, options);
  }

  static std::vector<std::pair<int, int>> Chain(int n) {
    std::vector<std::pair<int, int>> pairs;
    for (int k = 1; k < n; ++k) pairs.emplace_back(k - 1, k);
    return pairs;
  }

  // A graph with loops, a hub, parallel edges and some fixed nodes, on several levels.
  Hierarchy<G> MakeRandom(int n, int num_fixed) {
    std::vector<std::pair<int, int>> pairs = Chain(n);
    std::uniform_int_distribution<int> node(0, n - 1);
    for (int k = 0; k < n; ++k) {
      const int i = node(rng_), j = k % 4 == 0 ? n / 2 : std::min(n - 1, i + node(rng_) % 9 + 1);
      if (i == j) continue;
      pairs.emplace_back(i, j);
      if (k % 7 == 0) pairs.emplace_back(j, i);
    }
    std::set<int> fixed;
    for (int k = 0; k < num_fixed; ++k) fixed.insert(node(rng_));
    HierarchyOptions options;
    options.max_top_nodes = 8;
    return Make(n, pairs, fixed, options);
  }

  // Everything the header promises of a window that was just built.
  void Check(const Hierarchy<G>& hierarchy, int l, const std::vector<Index>& seeds,
             const WindowLimits& limits) {
    const Level<G>& level = hierarchy.level(l);
    const Subproblem<G>& problem = window_.subproblem();
    const std::vector<Index>& nodes = window_.nodes();
    EXPECT_EQ(window_.level(), l);
    ASSERT_EQ(nodes.size(), problem.poses.size());
    ASSERT_EQ(window_.edges().size(), problem.factors.size());
    EXPECT_EQ(std::set<Index>(nodes.begin(), nodes.end()).size(), nodes.size());
    EXPECT_LE(problem.num_free, limits.max_nodes);
    if (static_cast<int>(problem.factors.size()) > limits.max_edges) {
      EXPECT_EQ(problem.num_free, 1);
    }

    const std::set<Index> free(nodes.begin(), nodes.begin() + problem.num_free);
    std::multiset<Index> edges_at_free;
    std::set<Index> border;
    for (const Index n : free) {
      const auto& node = level.nodes[n];
      EXPECT_TRUE(node.alive && node.fixed == 0 &&
                  (node.degree <= limits.max_edges || free.size() == 1))
          << n;
      bool near = std::count(seeds.begin(), seeds.end(), n) > 0;
      ForEachEdge(level, n, [&](Index e, Index other) {
        edges_at_free.insert(e);
        if (other != kNone && free.count(other) == 0) border.insert(other);
        near |= free.count(other) > 0 || (other != kNone && other == held_);
      });
      EXPECT_TRUE(near) << "node " << n << " has no way to the seeds";
    }
    EXPECT_EQ(std::set<Index>(nodes.begin() + problem.num_free, nodes.end()), border);
    std::set<Index> expected_edges(edges_at_free.begin(), edges_at_free.end());
    EXPECT_EQ(std::set<Index>(window_.edges().begin(), window_.edges().end()), expected_edges);
    EXPECT_EQ(window_.edges().size(), expected_edges.size()) << "an edge came twice";

    for (std::size_t k = 0; k < nodes.size(); ++k) {
      EXPECT_EQ(window_.IsFree(nodes[k]), static_cast<int>(k) < problem.num_free);
      EXPECT_LE(hierarchy.WorldPose(l, nodes[k]).LocalCoordinates(problem.poses[k]).norm(), 1e-12);
    }
    for (std::size_t k = 0; k < problem.factors.size(); ++k) {
      const auto& edge = level.edges[window_.edges()[k]];
      const Factor<G>& factor = problem.factors[k];
      EXPECT_EQ(factor.i == kWorldFrame ? kNone : nodes[factor.i], edge.node[0]);
      EXPECT_EQ(nodes[factor.j], edge.node[1]);
      EXPECT_EQ(factor.term, hierarchy.FactorOf(l, window_.edges()[k]).term);
      EXPECT_TRUE(l == 0 || edge.merged);
      const bool interior =
          (edge.node[0] == kNone || free.count(edge.node[0]) > 0) && free.count(edge.node[1]) > 0;
      EXPECT_EQ(window_.IsInterior(k), interior);
      const G T = hierarchy.RelativePose(l, edge.node[0], edge.node[1]);
      EXPECT_LE(T.LocalCoordinates(window_.RelativePose(k)).norm(), 1e-12);
      EXPECT_LE(T.LocalCoordinates(window_.RelativePoseBefore(k)).norm(), 1e-12);
    }
  }

  // Poses of all nodes of all levels, as stored.
  static std::vector<std::vector<G>> StoredPoses(const Hierarchy<G>& hierarchy) {
    std::vector<std::vector<G>> poses(hierarchy.num_levels());
    for (int l = 0; l < hierarchy.num_levels(); ++l) {
      const Level<G>& level = hierarchy.level(l);
      for (std::size_t n = 0; n < level.nodes.size(); ++n) poses[l].push_back(level.nodes[n].pose);
    }
    return poses;
  }

  std::mt19937_64 rng_{5};
  Index held_ = kNone;  // by the gauge
  Window<G> window_;    // one object for all windows of a test
};

using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(WindowTest, Groups);

TYPED_TEST(WindowTest, CollectsBreadthFirstUpToTheNumberOfNodes) {
  Hierarchy<TypeParam> hierarchy = this->Make(100, this->Chain(100));
  ASSERT_TRUE(this->window_.Build(0, {50}, {5, 1000}, &hierarchy));
  EXPECT_EQ(this->window_.nodes()[0], 50);
  EXPECT_EQ(this->window_.subproblem().num_free, 5);
  EXPECT_THAT(this->window_.nodes(), UnorderedElementsAre(47, 48, 49, 50, 51, 52, 53));
  EXPECT_THAT(std::vector<Index>(this->window_.nodes().begin() + 5, this->window_.nodes().end()),
              UnorderedElementsAre(47, 53));
  EXPECT_EQ(this->window_.edges().size(), 6u);
  this->Check(hierarchy, 0, {50}, {5, 1000});
}

TYPED_TEST(WindowTest, SeedsComeFirstAndCountAsWell) {
  Hierarchy<TypeParam> hierarchy = this->Make(100, this->Chain(100));
  const std::vector<Index> seeds = {10, 30, 50, 70, 30, 90};
  ASSERT_TRUE(this->window_.Build(0, seeds, {7, 1000}, &hierarchy));
  EXPECT_THAT(std::vector<Index>(this->window_.nodes().begin(), this->window_.nodes().begin() + 5),
              ElementsAre(10, 30, 50, 70, 90));
  this->Check(hierarchy, 0, seeds, {7, 1000});
  ASSERT_TRUE(this->window_.Build(0, seeds, {3, 1000}, &hierarchy));
  EXPECT_EQ(this->window_.subproblem().num_free, 3);
  this->Check(hierarchy, 0, seeds, {3, 1000});
  EXPECT_FALSE(this->window_.Build(0, {}, {3, 1000}, &hierarchy));
}

TYPED_TEST(WindowTest, KeepsItsPromisesOnRandomGraphs) {
  std::uniform_int_distribution<int> choice(1, 60);
  for (int graph = 0; graph < 6; ++graph) {
    const int n = 40 + 30 * graph;
    Hierarchy<TypeParam> hierarchy = this->MakeRandom(n, 1 + 2 * graph);
    ASSERT_GE(hierarchy.num_levels(), 2);
    int built = 0;
    for (int trial = 0; trial < 60; ++trial) {
      const int l = trial % hierarchy.num_levels();
      const WindowLimits limits = {choice(this->rng_), 3 * choice(this->rng_)};
      std::vector<Index> seeds;
      for (int k = 0; k <= trial % 4; ++k) {
        seeds.push_back(
            hierarchy.Ancestor(static_cast<Index>(this->rng_() % static_cast<unsigned>(n)), l));
      }
      SCOPED_TRACE(testing::Message() << "graph " << graph << ", trial " << trial);
      if (!this->window_.Build(l, seeds, limits, &hierarchy)) {
        for (const Index seed : seeds) {
          EXPECT_GT(hierarchy.level(l).nodes[seed].fixed, 0);
        }
        continue;
      }
      ++built;
      this->Check(hierarchy, l, seeds, limits);
      if (testing::Test::HasFailure()) return;
    }
    EXPECT_GT(built, 30);
  }
}

// With room for all, a window ends at fixed nodes alone.
TYPED_TEST(WindowTest, EndsAtFixedNodes) {
  Hierarchy<TypeParam> hierarchy = this->Make(30, this->Chain(30), {10, 20});
  ASSERT_TRUE(this->window_.Build(0, {15}, kUnlimited, &hierarchy));
  EXPECT_EQ(this->window_.subproblem().num_free, 9);
  EXPECT_THAT(std::vector<Index>(this->window_.nodes().begin() + 9, this->window_.nodes().end()),
              UnorderedElementsAre(10, 20));
  this->Check(hierarchy, 0, {15}, kUnlimited);
  EXPECT_FALSE(this->window_.Build(0, {10, 20}, kUnlimited, &hierarchy));
}

TYPED_TEST(WindowTest, AGroupWithAFixedMemberIsBorder) {
  HierarchyOptions options;
  options.max_top_nodes = 4;
  Hierarchy<TypeParam> hierarchy = this->Make(60, this->Chain(60), {30}, options);
  for (int l = 1; l < hierarchy.num_levels(); ++l) {
    const Index group = hierarchy.Ancestor(30, l);
    EXPECT_FALSE(this->window_.Build(l, {group}, kUnlimited, &hierarchy));
    ASSERT_TRUE(this->window_.Build(l, {hierarchy.Ancestor(0, l)}, kUnlimited, &hierarchy));
    EXPECT_EQ(this->window_.nodes().back(), group);
    EXPECT_FALSE(this->window_.IsFree(group));
    this->Check(hierarchy, l, {hierarchy.Ancestor(0, l)}, kUnlimited);
  }
}

TYPED_TEST(WindowTest, AHubIsBorderOrHasAWindowAlone) {
  std::vector<std::pair<int, int>> pairs = this->Chain(50);
  for (int k = 2; k < 50; ++k) pairs.emplace_back(0, k);
  Hierarchy<TypeParam> hierarchy = this->Make(50, pairs);
  ASSERT_TRUE(this->window_.Build(0, {0, 7}, {10, 20}, &hierarchy));
  EXPECT_EQ(this->window_.subproblem().num_free, 1);
  EXPECT_TRUE(this->window_.IsFree(0));
  this->Check(hierarchy, 0, {0, 7}, {10, 20});
  ASSERT_TRUE(this->window_.Build(0, {25}, {10, 40}, &hierarchy));
  EXPECT_FALSE(this->window_.IsFree(0));
  EXPECT_EQ(this->window_.subproblem().num_free, 10);
  this->Check(hierarchy, 0, {25}, {10, 40});
  ASSERT_TRUE(this->window_.Build(0, {25}, {10, 1000}, &hierarchy));
  EXPECT_TRUE(this->window_.IsFree(0));
}

TYPED_TEST(WindowTest, TheNumberOfEdgesIsLimited) {
  std::vector<std::pair<int, int>> pairs;
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < i; ++j) pairs.emplace_back(j, i);
  }
  Hierarchy<TypeParam> hierarchy = this->Make(20, pairs);
  // The k-th node of a complete graph brings 20 - k edges.
  for (const auto& [max_edges, nodes] :
       std::map<int, int>{{18, 1}, {19, 1}, {36, 1}, {37, 2}, {54, 3}}) {
    ASSERT_TRUE(this->window_.Build(0, {3}, {20, max_edges}, &hierarchy));
    EXPECT_EQ(this->window_.subproblem().num_free, nodes) << max_edges;
    this->Check(hierarchy, 0, {3}, {20, max_edges});
  }
}

TYPED_TEST(WindowTest, HoldsTheGaugeWhereNothingElseDoes) {
  Hierarchy<TypeParam> hierarchy = this->Make(10, this->Chain(10));
  for (const Index seed : {0, 4, 9}) {
    ASSERT_TRUE(this->window_.Build(0, {seed}, kUnlimited, &hierarchy));
    EXPECT_EQ(this->window_.subproblem().num_free, 9);
    EXPECT_FALSE(this->window_.IsFree(seed));
    EXPECT_EQ(this->window_.nodes().back(), seed);
    this->held_ = seed;
    this->Check(hierarchy, 0, {seed + 1}, kUnlimited);
  }
  ASSERT_TRUE(this->window_.BuildWhole(0, &hierarchy));
  EXPECT_EQ(this->window_.subproblem().num_free, 9);
  EXPECT_FALSE(this->window_.IsFree(0));
}

TYPED_TEST(WindowTest, APriorHoldsTheGauge) {
  Hierarchy<TypeParam> hierarchy = this->Make(10, this->Chain(10));
  EdgeData<TypeParam> data;
  data.term.information =
      ceres_costs::PackedSymmetric<TypeParam::kDof>(TypeParam::Matrix::Identity());
  const Index prior = hierarchy.AddEdge(kNone, 6, data);
  ASSERT_TRUE(this->window_.Build(0, {2}, kUnlimited, &hierarchy));
  EXPECT_EQ(this->window_.subproblem().num_free, 10);
  EXPECT_THAT(this->window_.edges(), ::testing::Contains(prior));
  this->Check(hierarchy, 0, {2}, kUnlimited);
}

TYPED_TEST(WindowTest, ALonelyNodeIsNoWindow) {
  Hierarchy<TypeParam> hierarchy = this->Make(3, {{0, 1}});
  EXPECT_FALSE(this->window_.Build(0, {2}, kUnlimited, &hierarchy));
  ASSERT_TRUE(this->window_.Build(0, {0}, kUnlimited, &hierarchy));
  EXPECT_EQ(this->window_.subproblem().num_free, 1);
}

TYPED_TEST(WindowTest, ParallelEdgesAllCount) {
  using G = TypeParam;
  Hierarchy<G> hierarchy = this->Make(4, {{0, 1}, {1, 2}, {2, 1}, {1, 2}, {2, 3}, {3, 2}}, {0});
  ASSERT_TRUE(this->window_.Build(0, {1}, {2, 1000}, &hierarchy));
  EXPECT_EQ(this->window_.edges().size(), 6u);
  this->Check(hierarchy, 0, {1}, {2, 1000});
}

TYPED_TEST(WindowTest, CommitChangesFreeNodesAlone) {
  using G = TypeParam;
  Hierarchy<G> hierarchy = this->MakeRandom(150, 0);
  ASSERT_GE(hierarchy.num_levels(), 3);
  for (int l = 0; l < hierarchy.num_levels(); ++l) {
    ASSERT_TRUE(this->window_.Build(l, {hierarchy.Ancestor(20, l)}, {9, 1000}, &hierarchy));
    const auto before = this->StoredPoses(hierarchy);
    // Also the constant ones: they are not written back.
    for (G& pose : this->window_.subproblem().poses) {
      pose = pose * RandomPose<G>(&this->rng_, 1, 1);
    }
    const std::vector<G> wanted = this->window_.subproblem().poses;
    this->window_.Commit(&hierarchy);
    const auto after = this->StoredPoses(hierarchy);
    for (int other = 0; other < hierarchy.num_levels(); ++other) {
      for (Index n = 0; n < static_cast<Index>(after[other].size()); ++n) {
        const bool moved = std::memcmp(before[other][n].data(), after[other][n].data(),
                                       sizeof(double) * G::kParams) != 0;
        EXPECT_EQ(moved, other == l && this->window_.IsFree(n)) << other << " " << n;
      }
    }
    for (int k = 0; k < this->window_.subproblem().num_free; ++k) {
      const G actual = hierarchy.WorldPose(l, this->window_.nodes()[k]);
      EXPECT_LE(actual.LocalCoordinates(wanted[k]).norm(), 1e-12);
    }
  }
}

TYPED_TEST(WindowTest, KnowsRelativePosesBeforeAndAfter) {
  using G = TypeParam;
  Hierarchy<G> hierarchy = this->MakeRandom(60, 2);
  ASSERT_TRUE(this->window_.Build(0, {20}, {9, 1000}, &hierarchy));
  std::vector<G> before;
  for (const Index e : this->window_.edges()) {
    const auto& edge = hierarchy.level(0).edges[e];
    before.push_back(hierarchy.RelativePose(0, edge.node[0], edge.node[1]));
  }
  for (int k = 0; k < this->window_.subproblem().num_free; ++k) {
    G& pose = this->window_.subproblem().poses[k];
    pose = pose * RandomPose<G>(&this->rng_, 1, 1);
  }
  this->window_.Commit(&hierarchy);
  for (std::size_t k = 0; k < before.size(); ++k) {
    const auto& edge = hierarchy.level(0).edges[this->window_.edges()[k]];
    const G after = hierarchy.RelativePose(0, edge.node[0], edge.node[1]);
    EXPECT_LE(before[k].LocalCoordinates(this->window_.RelativePoseBefore(k)).norm(), 1e-12);
    EXPECT_LE(after.LocalCoordinates(this->window_.RelativePose(k)).norm(), 1e-12);
  }
}

TYPED_TEST(WindowTest, TakesBackItsMotions) {
  using G = TypeParam;
  Hierarchy<G> hierarchy = this->MakeRandom(60, 2);
  ASSERT_TRUE(this->window_.Build(0, {20}, {9, 1000}, &hierarchy));
  std::vector<G>& poses = this->window_.subproblem().poses;
  const std::vector<G> before = poses;
  for (int k = 0; k < this->window_.subproblem().num_free; ++k) {
    poses[k] = poses[k] * RandomPose<G>(&this->rng_, 1, 1);
  }
  this->window_.TakeBack();
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_EQ(before[k].LocalCoordinates(poses[k]).norm(), 0);
  }
}

// The objective of level 0, which windows of any level minimize.
template <typename G>
double FineCost(const Hierarchy<G>& hierarchy) {
  double sum = 0;
  const Level<G>& level = hierarchy.level(0);
  for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
    const auto& edge = level.edges[e];
    if (!edge.alive) continue;
    sum += FactorCost(hierarchy.FactorOf(0, e), edge.node[0] == kNone,
                      hierarchy.RelativePose(0, edge.node[0], edge.node[1]));
  }
  return sum;
}

TYPED_TEST(WindowTest, SolvedWindowsOfEveryLevelLowerTheObjective) {
  using G = TypeParam;
  HierarchyOptions options;
  options.max_top_nodes = 12;
  Hierarchy<G> hierarchy = MakeHierarchy(MakeKnownGraph<G>(200, 0.02, 3).graph, options);
  ASSERT_GE(hierarchy.num_levels(), 3);
  const auto solver = MakeBlockSolver<G>();
  double last = FineCost(hierarchy);
  for (int l = hierarchy.num_levels() - 1; l >= 0; --l) {
    ASSERT_TRUE(l % 2 == 0
                    ? this->window_.BuildWhole(l, &hierarchy)
                    : this->window_.Build(l, {hierarchy.Ancestor(100, l)}, {30, 1000}, &hierarchy));
    const SubproblemSummary summary =
        solver->Solve(SubproblemOptions(), &this->window_.subproblem());
    ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
    this->window_.Commit(&hierarchy);
    const double cost = FineCost(hierarchy);
    EXPECT_LT(cost, last) << "level " << l;
    last = cost;
  }
}

TYPED_TEST(WindowTest, TheWholeLevelIsTheWholeProblem) {
  using G = TypeParam;
  Hierarchy<G> hierarchy = this->MakeRandom(120, 2);
  hierarchy.RemoveNode(17);
  hierarchy.AssignGroups();
  ASSERT_TRUE(this->window_.BuildWhole(0, &hierarchy));
  const Level<G>& level = hierarchy.level(0);
  int free = 0;
  for (Index n = 0; n < static_cast<Index>(level.nodes.size()); ++n) {
    const bool expected = level.nodes[n].alive && level.nodes[n].fixed == 0;
    EXPECT_EQ(this->window_.IsFree(n), expected) << n;
    free += expected;
  }
  EXPECT_EQ(this->window_.subproblem().num_free, free);
  SubproblemOptions options;
  options.max_iterations = 50;
  const SubproblemSummary summary =
      MakeBlockSolver<G>()->Solve(options, &this->window_.subproblem());
  ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
  // All of the objective but the edges between fixed nodes.
  const double constant = FineCost(hierarchy) - summary.initial_cost;
  this->window_.Commit(&hierarchy);
  EXPECT_NEAR(FineCost(hierarchy) - constant, summary.final_cost, 1e-9 * summary.initial_cost);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

}  // namespace
}  // namespace hpgo
