#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
class MovesTest : public testing::Test {
 protected:
  MovesTest() : hierarchy_(Options()) {}
  static HierarchyOptions Options() {
    HierarchyOptions options;
    options.max_top_nodes = 6;
    return options;
  }
  G RandomPose(double size) {
    typename G::Tangent d;
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int k = 0; k < G::kDof; ++k) d(k) = size * uniform(rng_);
    return G::Exp(d);
  }
  void Grow(int nodes) {
    for (int k = 0; k < nodes; ++k) {
      const Index n =
          hierarchy_.AddNode(nodes_.empty() ? G() : Pose(nodes_.back()) * RandomPose(2));
      for (std::size_t back : {1, 5}) {
        if (nodes_.size() < back) continue;
        EdgeData<G> data;
        data.term.information =
            ceres_costs::PackedSymmetric<G::kDof>(typename G::Matrix(G::Matrix::Identity()));
        data.weight = 1;
        hierarchy_.AddEdge(nodes_[nodes_.size() - back], n, data);
      }
      nodes_.push_back(n);
      hierarchy_.AssignGroups();
    }
  }
  G Pose(Index n) const { return hierarchy_.WorldPose(0, n); }
  std::map<Index, G> Visit(double distance, double angle) {
    std::map<Index, G> visited;
    hierarchy_.ForEachMoved(distance, angle,
                            [&](Index n, const G& pose) { visited.emplace(n, pose); });
    return visited;
  }

  std::mt19937 rng_{11};
  Hierarchy<G> hierarchy_;
  std::vector<Index> nodes_;
};

using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(MovesTest, Groups);

TYPED_TEST(MovesTest, SurvivesTheLossOfLevels) {
  this->Grow(120);
  this->Visit(0, 0);
  ASSERT_GE(this->hierarchy_.num_levels(), 3);
  // Removals queue groups of upper levels for another try, and then drop these levels.
  while (this->hierarchy_.num_levels() > 1) {
    this->hierarchy_.RemoveNode(this->nodes_.back());
    this->nodes_.pop_back();
    const auto visited = this->Visit(1e9, 1e9);
    EXPECT_EQ(visited.size(), 0u);
  }
  this->hierarchy_.SetWorldPose(0, this->nodes_[2], this->RandomPose(5));
  EXPECT_EQ(this->Visit(1e-3, 1e-3).count(this->nodes_[2]), 1u);
}

TYPED_TEST(MovesTest, VisitsAllTheFirstTimeAndNoneTheSecond) {
  this->Grow(50);
  EXPECT_EQ(this->Visit(0.1, 0.1).size(), 50u);
  EXPECT_TRUE(this->Visit(0, 0).empty());
}

TYPED_TEST(MovesTest, VisitsNewNodes) {
  this->Grow(50);
  this->Visit(1, 1);
  this->Grow(3);
  const auto visited = this->Visit(1e9, 1e9);
  EXPECT_EQ(visited.size(), 3u);
  for (int k = 50; k < 53; ++k) EXPECT_EQ(visited.count(this->nodes_[k]), 1u);
}

// Against a plain comparison of every pose with the one last visited.
TYPED_TEST(MovesTest, VisitsExactlyThoseThatMovedEnough) {
  this->Grow(120);
  std::map<Index, TypeParam> last = this->Visit(0, 0);
  ASSERT_GE(this->hierarchy_.num_levels(), 3);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int step = 0; step < 300; ++step) {
    const int l = static_cast<int>(uniform(this->rng_) * this->hierarchy_.num_levels());
    const auto& level = this->hierarchy_.level(l);
    const Index n = static_cast<Index>(uniform(this->rng_) * level.nodes.size());
    if (!level.nodes[n].alive) continue;
    const double size = std::pow(10, -4 * uniform(this->rng_));
    this->hierarchy_.SetWorldPose(l, n, this->hierarchy_.WorldPose(l, n) * this->RandomPose(size));
    if (step % 10 == 0) this->Grow(1);
    if (step % 25 == 24) {
      this->hierarchy_.RemoveNode(this->nodes_[step / 25]);
      last.erase(this->nodes_[step / 25]);
      this->nodes_[step / 25] = kNone;
      this->hierarchy_.AssignGroups();
    }
    if (step % 3 != 0) continue;
    const double distance = 0.05, angle = 0.02;
    const auto visited = this->Visit(distance, angle);
    for (const Index node : this->nodes_) {
      if (node == kNone) continue;
      const TypeParam pose = this->Pose(node);
      if (visited.count(node) > 0) {
        last[node] = pose;
        continue;
      }
      ASSERT_EQ(last.count(node), 1u) << "a new node was not visited";
      const auto d = last.at(node).LocalCoordinates(pose);
      EXPECT_LE(d.template head<TypeParam::kDim>().norm(), distance * 1.0001) << step;
      EXPECT_LE(d.template tail<TypeParam::kRotationDof>().norm(), angle * 1.0001) << step;
    }
  }
}

}  // namespace
}  // namespace hpgo
