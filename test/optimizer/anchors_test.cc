// What holds the gauge: the first node of a component, fixed nodes, priors; and how components
// join.

#include <map>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class AnchorsTest : public testing::Test {
 protected:
  using Information = typename G::Matrix;

  static OptimizerOptions Options() {
    OptimizerOptions options;
    options.max_top_nodes = 5;
    return options;
  }
  // A session of its own: `nodes` nodes with ids from `first`, one an update, in a frame that is
  // `frame` away from the truth.
  void AddSession(NodeId first, int nodes, const G& frame) {
    for (int k = 0; k < nodes; ++k) {
      truth_[first + k] = RandomPose<G>(&rng_, 5, 1);
      if (k > 0) truth_[first + k] = truth_[first + k - 1] * RandomPose<G>(&rng_, 1, 0.5);
      const NodeId id = first + k;
      ASSERT_TRUE(optimizer_.AddNode(id, frame * truth_[id]).ok());
      if (k > 0) AddEdge(id - 1, id);
      if (k > 4 && k % 3 == 0) AddEdge(id - 5, id);
      optimizer_.Update();
    }
  }
  EdgeId AddEdge(NodeId i, NodeId j) {
    const G Z = truth_[i].Between(truth_[j]) * RandomPose<G>(&rng_, noise_, noise_);
    return *optimizer_.AddEdge(i, j, Z, 100 * Information::Identity());
  }
  double Distance(NodeId id, const G& pose) {
    return pose.LocalCoordinates(*optimizer_.GetPose(id)).norm();
  }

  std::mt19937_64 rng_{11};
  double noise_ = 0.02;
  std::map<NodeId, G> truth_;
  Optimizer<G> optimizer_{Options()};
};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(AnchorsTest, Groups);

TYPED_TEST(AnchorsTest, TheFirstNodeOfEachComponentStaysPut) {
  const TypeParam frame = RandomPose<TypeParam>(&this->rng_, 30, 3);
  this->AddSession(0, 25, TypeParam());
  this->AddSession(100, 25, frame);
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->Distance(0, this->truth_[0]), 1e-12);
  EXPECT_LT(this->Distance(100, frame * this->truth_[100]), 1e-12);
  EXPECT_LT(Gap(this->optimizer_), 1e-4);
}

// From any relative frame, by an edge between any two of their nodes.
TYPED_TEST(AnchorsTest, TheYoungerComponentMovesAsAWhole) {
  this->noise_ = 0;
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(trial);
    this->rng_.seed(trial);
    this->optimizer_.Clear();
    const int a = 1 + trial % 9, b = 1 + trial / 9 % 7;
    this->AddSession(0, a, TypeParam());
    this->AddSession(100, b, RandomPose<TypeParam>(&this->rng_, 30, 3));
    std::uniform_int_distribution<int> in_a(0, a - 1), in_b(0, b - 1);
    const NodeId i = in_a(this->rng_), j = 100 + in_b(this->rng_);
    trial % 2 == 0 ? this->AddEdge(i, j) : this->AddEdge(j, i);
    this->optimizer_.Update();
    ASSERT_EQ(this->optimizer_.FindInconsistency(), "");
    for (const auto& [id, pose] : this->truth_) {
      EXPECT_LT(this->Distance(id, pose), 1e-6) << id;
    }
    this->truth_.clear();
  }
}

TYPED_TEST(AnchorsTest, SeveralJoinInOneUpdateThroughNewNodes) {
  this->noise_ = 0;
  this->AddSession(0, 8, TypeParam());
  this->AddSession(100, 8, RandomPose<TypeParam>(&this->rng_, 30, 3));
  this->AddSession(200, 8, RandomPose<TypeParam>(&this->rng_, 30, 3));
  // 200 - new - 100 and 100 - 3; the new node stands where its neighbour in 200 sees it.
  this->truth_[300] = this->truth_[204] * RandomPose<TypeParam>(&this->rng_, 1, 1);
  const TypeParam Z = this->truth_[204].Between(this->truth_[300]);
  ASSERT_TRUE(this->optimizer_.AddNode(300, *this->optimizer_.GetPose(204) * Z).ok());
  this->AddEdge(204, 300);
  this->AddEdge(300, 105);
  this->AddEdge(107, 3);
  this->optimizer_.Update();
  for (const auto& [id, pose] : this->truth_) EXPECT_LT(this->Distance(id, pose), 1e-6) << id;
  EXPECT_EQ(this->optimizer_.FindInconsistency(), "");
}

TYPED_TEST(AnchorsTest, OneAnchorIsLeftAfterJoining) {
  this->AddSession(0, 12, TypeParam());
  this->AddSession(100, 12, TypeParam());
  for (int k = 0; k < 12; k += 2) this->AddEdge(k, 100 + k);
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->Distance(0, this->truth_[0]), 1e-12);
  EXPECT_GT(this->Distance(100, this->truth_[100]), 1e-6);  // released
  EXPECT_LT(Gap(this->optimizer_), 1e-4);
}

TYPED_TEST(AnchorsTest, ComponentsThatComeApartAreAnchoredAgain) {
  this->AddSession(0, 10, TypeParam());
  this->AddSession(100, 10, RandomPose<TypeParam>(&this->rng_, 30, 3));
  const EdgeId bridge = this->AddEdge(5, 105);
  this->optimizer_.Refine();
  ASSERT_TRUE(this->optimizer_.RemoveEdge(bridge).ok());
  this->optimizer_.Update();
  const TypeParam before = *this->optimizer_.GetPose(109);
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->Distance(109, before), 0.01);  // nothing drives it away
  ASSERT_TRUE(this->optimizer_.RemoveNode(0).ok());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(Gap(this->optimizer_), 1e-4);
  EXPECT_TRUE(this->optimizer_.MarginalCovariance(9).ok());
  EXPECT_TRUE(this->optimizer_.MarginalCovariance(109).ok());
}

TYPED_TEST(AnchorsTest, AFixedNodeOrAPriorReplacesTheAnchor) {
  this->AddSession(0, 12, RandomPose<TypeParam>(&this->rng_, 1, 0.2));
  ASSERT_TRUE(this->optimizer_.SetPose(6, this->truth_[6]).ok());
  ASSERT_TRUE(this->optimizer_.SetFixed(6, true).ok());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->Distance(6, this->truth_[6]), 1e-12);
  EXPECT_LT(this->Distance(0, this->truth_[0]), 0.2);  // has come along
  EXPECT_LT(Gap(this->optimizer_), 1e-4);

  ASSERT_TRUE(this->optimizer_.SetFixed(6, false).ok());
  const TypeParam there = RandomPose<TypeParam>(&this->rng_, 2, 0.3) * this->truth_[3];
  ASSERT_TRUE(this->optimizer_.AddPrior(3, there, TypeParam::Matrix::Identity()).ok());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->Distance(3, there), 1e-3);
}

}  // namespace
}  // namespace hpgo
