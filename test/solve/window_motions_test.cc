// Windows: what becomes of the poses.

#include <cstring>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "hpgo/solve/window.h"
#include "small_graphs.h"
#include "small_hierarchies.h"
#include "test/hierarchy/level_cost.h"
#include "window_fixture.h"

namespace hpgo {
namespace {

template <typename G>
class WindowMotionsTest : public WindowFixture<G> {};
TYPED_TEST_SUITE(WindowMotionsTest, WindowGroups);

TYPED_TEST(WindowMotionsTest, CommitChangesFreeNodesAlone) {
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

TYPED_TEST(WindowMotionsTest, KnowsRelativePosesBeforeAndAfter) {
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

TYPED_TEST(WindowMotionsTest, TakesBackItsMotions) {
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

// That of level 0, which windows of any level minimize.
TYPED_TEST(WindowMotionsTest, SolvedWindowsOfEveryLevelLowerTheObjective) {
  using G = TypeParam;
  HierarchyOptions options;
  options.max_top_nodes = 12;
  Hierarchy<G> hierarchy = MakeHierarchy(MakeKnownGraph<G>(200, 0.02, 3).graph, options);
  ASSERT_GE(hierarchy.num_levels(), 3);
  const auto solver = MakeBlockSolver<G>();
  double last = CostOfLevel(hierarchy, 0);
  for (int l = hierarchy.num_levels() - 1; l >= 0; --l) {
    ASSERT_TRUE(l % 2 == 0
                    ? this->window_.BuildWhole(l, &hierarchy)
                    : this->window_.Build(l, {hierarchy.Ancestor(100, l)}, {30, 1000}, &hierarchy));
    const SubproblemSummary summary =
        solver->Solve(SubproblemOptions(), &this->window_.subproblem());
    ASSERT_TRUE(summary.status.ok()) << summary.status.ToString();
    this->window_.Commit(&hierarchy);
    const double cost = CostOfLevel(hierarchy, 0);
    EXPECT_LT(cost, last) << "level " << l;
    last = cost;
  }
}

TYPED_TEST(WindowMotionsTest, TheWholeLevelIsTheWholeProblem) {
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
  const double constant = CostOfLevel(hierarchy, 0) - summary.initial_cost;
  this->window_.Commit(&hierarchy);
  EXPECT_NEAR(CostOfLevel(hierarchy, 0) - constant, summary.final_cost,
              1e-9 * summary.initial_cost);
  EXPECT_LT(summary.final_cost, summary.initial_cost);
}

}  // namespace
}  // namespace hpgo
