// What it costs to bend a straight chain into an arc, and where that ends.

#include "gtest/gtest.h"
#include "hpgo/chains/span_tree.h"

namespace hpgo {
namespace {

template <typename G>
class SettleTest : public testing::Test {
 protected:
  // A chain of `edges` ahead, 1 m each, with a standard deviation of 0.01 in every direction.
  SettleTest() { ahead_(0) = 1; }
  Index Straight(int edges) {
    ceres_costs::RelativePoseTerm<G> term;
    term.measurement = G().Plus(ahead_);
    term.information = ceres_costs::PackedSymmetric<G::kDof>((1e4 * G::Matrix::Identity()).eval());
    Index root = kNone;
    for (int k = 0; k < edges; ++k) {
      root = tree_.Concatenate(root, tree_.RootOf(tree_.AddEdge(term, k, false)));
    }
    return root;
  }
  // Of its ends where it turns by so much, in rad.
  G Arc(int edges, double turn) const {
    typename G::Tangent d = ahead_;
    d(G::kDof - 1) = turn / edges;
    G T;
    for (int k = 0; k < edges; ++k) T = T * G().Plus(d);
    return T;
  }

  typename G::Tangent ahead_ = G::Tangent::Zero();
  SpanTree<G> tree_{ceres_costs::ErrorConvention::kTwist};
};
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(SettleTest, Groups);

TYPED_TEST(SettleTest, TheWayCostsWhatBends) {
  constexpr int kEdges = 4096;
  const Index root = this->Straight(kEdges);
  EXPECT_LT(this->tree_.Settle(root, this->Arc(kEdges, 1), 1e-3), 3 * kEdges);
}

// At the end all leaves are looked at, but few of them miss anything.
TYPED_TEST(SettleTest, TheEndCostsWhatMisses) {
  constexpr int kEdges = 4096;
  const Index root = this->Straight(kEdges);
  EXPECT_LT(this->tree_.Settle(root, this->Arc(kEdges, 0.6), 1e-3), kEdges / 2);
}

// Each edge turns by 2 / 64 rad there.
TYPED_TEST(SettleTest, AnArcIsReachedAtItsCost) {
  constexpr int kEdges = 64;
  const Index root = this->Straight(kEdges);
  this->tree_.Settle(root, this->Arc(kEdges, 2), 1e-3);
  EXPECT_TRUE(this->tree_.TakeUnfit().empty());
  EXPECT_NEAR(this->tree_.Model(root).cost, 1e4 * 2 * 2 / kEdges, 1);
}

// Where edges turn by less than a hundredth of a rad, but all of them together by more than a
// linearization reaches, the first step to the end leaves a part of the way, or a thousand times
// the cost.
TYPED_TEST(SettleTest, WhatComesFromAfarIsLookedAtAgain) {
  const Index near = this->Straight(128);
  this->tree_.Settle(near, this->Arc(128, 0.6), 1e-3);
  EXPECT_NEAR(this->tree_.Model(near).cost, 1e4 * 0.6 * 0.6 / 128, 0.1);
  EXPECT_TRUE(this->tree_.TakeUnfit().empty());
  const Index far = this->Straight(2048);
  this->tree_.Settle(far, this->Arc(2048, 0.7), 1e-3);
  EXPECT_FALSE(this->tree_.TakeUnfit().empty()) << "it is to be cut";
}

}  // namespace
}  // namespace hpgo
