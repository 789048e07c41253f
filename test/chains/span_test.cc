// Stretches of chains against a dense elimination of what is between their ends.

#include "hpgo/chains/span_tree.h"

#include <cmath>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;

constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kTwist,
                                            ErrorConvention::kSplitLog};

template <typename G>
class SpanTest : public testing::Test {
 protected:
  using Matrix = typename G::Matrix;
  using Tangent = typename G::Tangent;

  ceres_costs::RelativePoseTerm<G> RandomTerm() {
    ceres_costs::RelativePoseTerm<G> term;
    term.measurement = RandomPose<G>(&rng_, 1, 0.3);
    term.information = ceres_costs::PackedSymmetric<G::kDof>(RandomInformation<G>(&rng_));
    return term;
  }
  // Appends edges to a chain; every third runs against its measurement.
  Index Append(int count, Index root) {
    for (int k = 0; k < count; ++k) {
      edges_.push_back(
          tree_.AddEdge(RandomTerm(), static_cast<Index>(edges_.size()), edges_.size() % 3 == 2));
      root = tree_.Concatenate(root, tree_.RootOf(edges_.back()));
    }
    return root;
  }
  // The measurements composed.
  G Composed(Index from, Index to) const {
    G T;
    for (Index k = from; k < to; ++k) {
      const ChainEdge<G>& edge = tree_.edge(edges_[k]);
      T = T * (edge.reversed ? edge.term.measurement.Inverse() : edge.term.measurement);
    }
    return T;
  }

  // An empty tree for edges of this convention.
  void Begin(ErrorConvention convention) {
    convention_ = convention;
    tree_ = SpanTree<G>(convention);
    edges_.clear();
  }
  // Every edge away from its measurement.
  void Bend(Index root) {
    tree_.LinearizeAt(
        root, [&](const ChainEdge<G>& edge) { return edge.Y * RandomPose<G>(&rng_, 0.1, 0.1); });
  }
  ceres_costs::FactorTerm<G> FactorOf(const ChainEdge<G>& edge) const {
    ceres_costs::FactorTerm<G> factor;
    factor.term = &edge.term;
    factor.convention = convention_;
    return factor;
  }

  std::mt19937_64 rng_{7};
  ErrorConvention convention_ = ErrorConvention::kG2o;
  SpanTree<G> tree_{convention_};
  std::vector<Index> edges_;
};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(SpanTest, Groups);

TYPED_TEST(SpanTest, AChainPrefersWhatItsMeasurementsSay) {
  const Index root = this->Append(100, kNone);
  EXPECT_STREQ(this->tree_.Inconsistency(root), "");
  const SpanModel<TypeParam>& model = this->tree_.Model(root);
  EXPECT_LT(model.shift.norm(), 1e-9);
  EXPECT_LT(model.T.LocalCoordinates(this->Composed(0, 100)).norm(), 1e-9);
}

// Of the information of the ends, by eliminating the nodes between in one dense system.
TYPED_TEST(SpanTest, TheModelIsTheSchurComplement) {
  constexpr int D = TypeParam::kDof, kEdges = 40;
  for (const ErrorConvention convention : kConventions) {
    this->Begin(convention);
    const Index root = this->Append(kEdges, kNone);
    this->Bend(root);
    // Node 0 is held; those behind the edges are unknown.
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(D * kEdges, D * kEdges);
    for (int k = 0; k < kEdges; ++k) {
      const ChainEdge<TypeParam>& edge = this->tree_.edge(this->edges_[k]);
      ceres_costs::QuadraticModel<TypeParam> at_j, at_i;
      const TypeParam T = edge.reversed ? edge.Y.Inverse() : edge.Y;
      ASSERT_TRUE(LinearizeFactor(this->FactorOf(edge), false, T, &at_j));
      typename TypeParam::Matrix cross;  // row j, column i
      TransportModel(T.Inverse(), at_j, &at_i, &cross);
      const int i = edge.reversed ? k : k - 1, j = edge.reversed ? k - 1 : k;
      if (j >= 0) H.template block<D, D>(D * j, D * j) += at_j.A;
      if (i >= 0) H.template block<D, D>(D * i, D * i) += at_i.A;
      if (i < 0 || j < 0) continue;
      H.template block<D, D>(D * j, D * i) -= cross;
      H.template block<D, D>(D * i, D * j) -= cross.transpose();
    }
    const Eigen::MatrixXd expected = H.inverse().bottomRightCorner(D, D);
    const typename TypeParam::Matrix covariance = this->tree_.Model(root).covariance.Dense();
    EXPECT_LT((covariance - expected).norm(), 1e-9 * expected.norm());
  }
}

// What a step has gained is the difference of two of them.
TYPED_TEST(SpanTest, ItCostsWhatItsEdgesCostWhereTheyAre) {
  for (const ErrorConvention convention : kConventions) {
    this->Begin(convention);
    const Index root = this->Append(40, kNone);
    this->Bend(root);
    double cost = 0;
    for (const Index e : this->edges_) {
      const ChainEdge<TypeParam>& edge = this->tree_.edge(e);
      cost += FactorCost(this->FactorOf(edge), false, edge.reversed ? edge.Y.Inverse() : edge.Y);
    }
    EXPECT_GT(cost, 0.1);
    EXPECT_NEAR(this->tree_.Model(root).cost, cost, 1e-9 * cost);
  }
}

TYPED_TEST(SpanTest, ASplitChainIsItsTwoParts) {
  for (const int at : {0, 1, 15, 16, 17, 63, 98, 99}) {
    this->edges_.clear();
    const Index root = this->Append(100, kNone);
    ASSERT_NE(root, kNone);
    Index before, after;
    this->tree_.Split(this->edges_[at], &before, &after);
    ASSERT_EQ(before == kNone, at == 0);
    ASSERT_EQ(after == kNone, at == 99);
    if (before != kNone) {
      EXPECT_STREQ(this->tree_.Inconsistency(before), "");
      EXPECT_LT(this->tree_.Model(before).T.LocalCoordinates(this->Composed(0, at)).norm(), 1e-9);
    }
    if (after != kNone) {
      EXPECT_STREQ(this->tree_.Inconsistency(after), "");
      EXPECT_LT(this->tree_.Model(after).T.LocalCoordinates(this->Composed(at + 1, 100)).norm(),
                1e-9);
    }
    // Put together again, it is as it was.
    const Index again = this->tree_.Concatenate(
        this->tree_.Concatenate(before, this->tree_.NewLeaf(this->edges_[at])), after);
    EXPECT_STREQ(this->tree_.Inconsistency(again), "");
    EXPECT_LT(this->tree_.Model(again).T.LocalCoordinates(this->Composed(0, 100)).norm(), 1e-9);
  }
}

TYPED_TEST(SpanTest, TheOtherWayRoundItIsTheInverse) {
  const Index root = this->Append(50, kNone);
  const TypeParam T = this->tree_.Model(root).T;
  const Index reversed = this->tree_.Reversed(root);
  EXPECT_STREQ(this->tree_.Inconsistency(reversed), "");
  EXPECT_LT(this->tree_.Model(reversed).T.LocalCoordinates(T.Inverse()).norm(), 1e-9);
}

// Linearized where a bad step had put it, all edges turned at random, no step from there is within
// reach of a linearization: it would stay a knot for ever.
TYPED_TEST(SpanTest, AKnotIsUntied) {
  const Index root = this->Append(200, kNone);
  const TypeParam T = this->tree_.Model(root).T;
  this->tree_.LinearizeAt(
      root, [&](const ChainEdge<TypeParam>&) { return RandomPose<TypeParam>(&this->rng_, 1, 1); });
  this->tree_.Settle(root, T, 1e-3);
  const SpanModel<TypeParam>& model = this->tree_.Model(root);
  EXPECT_LT(ShiftAt(model, T).norm(), 1e-6);
  EXPECT_LT(model.T.LocalCoordinates(T).norm(), 1e-6);
}

TYPED_TEST(SpanTest, TheSofterTheLessItWeighs) {
  SpanModel<TypeParam> model;
  const double exact = ChainWeight(model);
  EXPECT_TRUE(std::isfinite(exact));
  model.covariance =
      ceres_costs::PackedSymmetric<TypeParam::kDof>(TypeParam::Matrix::Identity().eval());
  EXPECT_GT(ChainWeight(model), 0);
  EXPECT_LT(ChainWeight(model), exact);
}

// To ends further apart than the chain is long no step is within reach.
TYPED_TEST(SpanTest, WhatCannotGetThereIsCut) {
  const Index root = this->Append(64, kNone);
  (void)this->tree_.TakeUnfit();
  typename TypeParam::Tangent d = TypeParam::Tangent::Zero();
  d(0) = 1e4;
  const TypeParam far = TypeParam().Retract(d);
  this->tree_.Settle(root, far, 1e-3);
  EXPECT_FALSE(this->tree_.TakeUnfit().empty());
  EXPECT_STREQ(this->tree_.Inconsistency(root), "");
}

// Bent and settled, its relative poses still lead from one end to the other, and their cost no
// longer falls along any of them.
TYPED_TEST(SpanTest, InteriorsAreAtTheirConditionalOptimum) {
  constexpr int D = TypeParam::kDof;
  for (const ErrorConvention convention : kConventions) {
    this->Begin(convention);
    const Index root = this->Append(60, kNone);
    typename TypeParam::Tangent bend = TypeParam::Tangent::Constant(0.3);
    const TypeParam T = this->tree_.Model(root).T.Retract(bend);
    this->tree_.SettleAll(root, T);
    std::vector<TypeParam> poses;
    TypeParam product;
    this->tree_.ForEachEdge(root, T, Inside::kMean, [&](Index, const TypeParam& Y) {
      poses.push_back(Y);
      product = product * Y;
    });
    EXPECT_LT(product.LocalCoordinates(T).norm(), 1e-9);
    const auto cost = [&](int node, const typename TypeParam::Tangent& d) {
      double sum = 0;
      for (int k = node; k <= node + 1; ++k) {
        const ChainEdge<TypeParam>& edge = this->tree_.edge(this->edges_[k]);
        const TypeParam moved = TypeParam().Retract(d);
        const TypeParam Y = k == node ? poses[k] * moved : moved.Inverse() * poses[k];
        sum += FactorCost(this->FactorOf(edge), false, edge.reversed ? Y.Inverse() : Y);
      }
      return sum;
    };
    constexpr double h = 1e-5;
    for (const int node : {0, 7, 15, 16, 40, 58}) {
      for (int c = 0; c < D; ++c) {
        typename TypeParam::Tangent d = TypeParam::Tangent::Zero();
        d(c) = h;
        const double slope = (cost(node, d) - cost(node, -d)) / (2 * h);
        EXPECT_NEAR(slope, 0, 1e-4 * (1 + cost(node, TypeParam::Tangent::Zero()) / h * 1e-3))
            << node << ' ' << c;
      }
    }
  }
}

}  // namespace
}  // namespace hpgo
