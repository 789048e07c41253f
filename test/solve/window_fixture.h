// Hierarchies for the tests of windows, and what a window promises.
#pragma once

#include <algorithm>
#include <cstddef>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/solve/window.h"
#include "small_graphs.h"
#include "small_hierarchies.h"

namespace hpgo {

template <typename G>
class WindowFixture : public testing::Test {
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

using WindowGroups = testing::Types<SE2, SE3>;

}  // namespace hpgo
