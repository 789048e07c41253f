// Windows: which nodes and edges they take.

#include "hpgo/solve/window.h"

#include <map>
#include <random>
#include <set>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "window_fixture.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

constexpr WindowLimits kUnlimited = {1000000, 1000000};

template <typename G>
class WindowTest : public WindowFixture<G> {};
TYPED_TEST_SUITE(WindowTest, WindowGroups);

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

}  // namespace
}  // namespace hpgo
