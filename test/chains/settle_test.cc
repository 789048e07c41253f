// What it costs to bend a straight chain into an arc, and where that ends.

#include <cstdint>
#include <utility>
#include <vector>

#include "ceres_costs/factor_term.h"
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

  // Of its edges, one by one.
  double Cost(Index root, const G& T) {
    double cost = 0;
    tree_.ForEachEdge(root, T, Inside::kMean, [&](Index e, const G& Y) {
      ceres_costs::FactorTerm<G> factor;
      factor.term = &tree_.edge(e).term;
      factor.convention = ceres_costs::ErrorConvention::kTwist;
      cost += FactorCost(factor, false, Y);
    });
    return cost;
  }

  typename G::Tangent ahead_ = G::Tangent::Zero();
  SpanTree<G> tree_{ceres_costs::ErrorConvention::kTwist};
};
using Groups = testing::Types<ceres_costs::SE2, ceres_costs::SE3, ceres_costs::YawPose>;
TYPED_TEST_SUITE(SettleTest, Groups);

// At the end all leaves are looked at, but few of them miss anything.
TYPED_TEST(SettleTest, TheWayCostsWhatBendsAndTheEndWhatMisses) {
  constexpr int kEdges = 4096;
  const Index far = this->Straight(kEdges), near = this->Straight(kEdges);
  EXPECT_LT(this->tree_.Settle(far, this->Arc(kEdges, 1), 1e-3).edges, 3 * kEdges);
  EXPECT_LT(this->tree_.Settle(near, this->Arc(kEdges, 0.6), 1e-3).edges, kEdges / 2);
}

TYPED_TEST(SettleTest, AnArcIsReachedAtItsCost) {
  const Index root = this->Straight(64);
  this->tree_.Settle(root, this->Arc(64, 2), 1e-3);
  EXPECT_TRUE(this->tree_.TakeUnfit().empty());
  EXPECT_NEAR(this->tree_.Model(root).cost, 1e4 * 2 * 2 / 64, 1);
}

// It is linearized where it rests; its ends move a little, as by the second step of a solve.
TYPED_TEST(SettleTest, WhatHardlyBendsIsNotLinearizedAgain) {
  const Index root = this->Straight(64);
  this->tree_.SettleAll(root, this->Arc(64, 0.3));
  for (const auto& [turn, is_again] : {std::pair(0.3005, false), std::pair(0.32, true)}) {
    const TypeParam T = this->Arc(64, turn);
    EXPECT_EQ(this->tree_.Settle(root, T, 1e-8).edges > 0, is_again) << turn;
    EXPECT_NEAR(ChiSquareAt(this->tree_.Model(root), T) / this->Cost(root, T), 1, 1e-3);
  }
  EXPECT_GT(this->tree_.SettleAll(root, this->Arc(64, 0.3203)).edges, 0) << "all of it";
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
  EXPECT_FALSE(this->tree_.Settle(far, this->Arc(2048, 0.7), 1e-3).holds);
  EXPECT_FALSE(this->tree_.TakeUnfit().empty()) << "it is to be cut";
}

// Neither where steps on its way were well, nor where it began again at its measurements.
TYPED_TEST(SettleTest, WhatDoesNotGetThereIsAsItWas) {
  typename TypeParam::Tangent far = TypeParam::Tangent::Zero();
  far(1) = 1e4;
  const std::pair<int, TypeParam> ends[] = {{2048, this->Arc(2048, 0.7)},
                                            {64, TypeParam().Plus(far)}};
  for (const auto& [edges, T] : ends) {
    const Index root = this->Straight(edges);
    this->tree_.Settle(root, this->Arc(edges, 0.1), 1e-3);
    const SpanModel<TypeParam> before = this->tree_.Model(root);
    EXPECT_FALSE(this->tree_.Settle(root, T, 1e-3).holds);
    EXPECT_FALSE(this->tree_.TakeUnfit().empty()) << "it is to be cut";
    const SpanModel<TypeParam>& after = this->tree_.Model(root);
    EXPECT_EQ(after.T.translation(), before.T.translation());
    EXPECT_EQ(after.cost, before.cost);
    EXPECT_EQ(after.shift, before.shift);
  }
}

// Though others have named theirs, and nobody has asked yet.
TYPED_TEST(SettleTest, EveryChainThatDoesNotGetThereNamesAnEdge) {
  typename TypeParam::Tangent far = TypeParam::Tangent::Zero();
  far(1) = 1e4;
  for (const int edges : {64, 12}) {
    for (int chain = 0; chain < 2; ++chain) {
      EXPECT_FALSE(this->tree_.SettleAll(this->Straight(edges), TypeParam().Plus(far)).holds);
    }
    const std::vector<Index> unfit = this->tree_.TakeUnfit();
    EXPECT_GE(unfit.size(), 2u) << edges;
    for (const Index edge : unfit) EXPECT_NEAR(edge, edges / 2, edges / 4) << edges;
  }
}

// The pull of a chain is that of one edge, whose error is about to wrap there.
TYPED_TEST(SettleTest, WhatIsBentByAlmostHalfATurnIsCut) {
  // With three angles it is two tangents of the half of it, which reach further.
  const bool wraps = TypeParam::kRotationDof == 1;
  const Index near = this->Straight(64), far = this->Straight(64);
  EXPECT_TRUE(this->tree_.Settle(near, this->Arc(64, 2.3), 1e-3).holds);
  EXPECT_EQ(this->tree_.Settle(far, this->Arc(64, 2.7), 1e-3).holds, !wraps);
  EXPECT_EQ(this->tree_.TakeUnfit().empty(), !wraps);
}

// A leaf is not at its optimum where its first step ends, though its ends are where they should be:
// an S here.
TYPED_TEST(SettleTest, TheInsideOfALeafComesToRest) {
  const Index root = this->Straight(12);
  typename TypeParam::Tangent d = TypeParam::Tangent::Zero();
  d(0) = 11;
  d(1) = 3;
  ASSERT_TRUE(this->tree_.Settle(root, TypeParam().Plus(d), 1e-3).holds);
  const SpanModel<TypeParam>& model = this->tree_.Model(root);
  EXPECT_LT(GainAt(model), 0.01 * model.cost);
}

// Stiff in its distances and soft in its turns, as odometry is: where it is bent the edges share
// what a straight step misses, and the last one does not tear. It costs what it is said to cost.
TYPED_TEST(SettleTest, NoEdgeOfABentLeafTears) {
  using G = TypeParam;
  ceres_costs::RelativePoseTerm<G> term;
  term.measurement = G().Plus(this->ahead_);
  typename G::Tangent weights = G::Tangent::Constant(1e2);
  weights.template head<G::kDim>().setConstant(1e6);
  term.information =
      ceres_costs::PackedSymmetric<G::kDof>(typename G::Matrix(weights.asDiagonal()));
  Index root = kNone;
  for (int k = 0; k < 12; ++k) {
    root = this->tree_.Concatenate(root, this->tree_.RootOf(this->tree_.AddEdge(term, k, false)));
  }
  const G T = this->Arc(12, 0.2);
  double cost = 0, last = 0;
  this->tree_.ForEachEdge(root, T, Inside::kMean, [&](Index e, const G& Y) {
    ceres_costs::FactorTerm<G> factor;
    factor.term = &this->tree_.edge(e).term;
    factor.convention = ceres_costs::ErrorConvention::kTwist;
    cost += last = FactorCost(factor, false, Y);
  });
  EXPECT_LT(last, cost / 2);
  EXPECT_LT(cost, 2 * 1e2 * 0.2 * 0.2 / 12);
  EXPECT_NEAR(this->tree_.CostAt(root, T, Inside::kMean), cost, 1e-9 * cost);
  const G T_before = this->tree_.Model(root).T;
  LinearizationLog<G> log;
  ASSERT_TRUE(this->tree_.Settle(root, T, 1e-3, false, &log).holds);
  const LogMark settled = log.End();
  const G T_settled = this->tree_.Model(root).T;
  EXPECT_NE(T_settled.translation(), T_before.translation());
  ASSERT_TRUE(this->tree_.Settle(root, this->Arc(12, 0.1), 1e-3, false, &log).holds);
  EXPECT_NE(this->tree_.Model(root).T.translation(), T_settled.translation());
  this->tree_.PutBack(settled, &log);
  EXPECT_EQ(this->tree_.Model(root).T.translation(), T_settled.translation());
  this->tree_.PutBack(LogMark(), &log);
  EXPECT_EQ(this->tree_.Model(root).T.translation(), T_before.translation());
  EXPECT_EQ(this->tree_.CostAt(root, T, Inside::kMean), cost);
}

// What it costs to bend is asked of the spans that bend far, not of the edges: of a long chain on
// an arc of which each leaf hardly bends none is looked at. A leaf that is bent costs what its
// edges do.
TYPED_TEST(SettleTest, WhatHardlyBendsIsNotAskedEdgeByEdge) {
  constexpr int kEdges = 1024;
  for (const auto& [num_edges, asked] : {std::pair(kEdges, 0), std::pair(12, 12)}) {
    const Index root = this->Straight(num_edges);
    const TypeParam T = this->Arc(num_edges, 0.6);
    const double cost = this->Cost(root, T);
    std::int64_t edges = 0;
    EXPECT_NEAR(this->tree_.CostAt(root, T, Inside::kMean, &edges), cost, 0.02 * cost);
    EXPECT_EQ(edges, asked);
  }
}

// Where the bend costs far more than what the nodes between would still gain, that is not asked
// for.
TYPED_TEST(SettleTest, WhatGainsLittleBesideItsBendIsNotAskedEdgeByEdge) {
  constexpr int kEdges = 1024;
  const Index root = this->Straight(kEdges);
  const TypeParam T = this->Arc(kEdges, 0.6);
  for (const bool gains_much : {false, true}) {
    this->tree_.LinearizeAt(root, [&](const ChainEdge<TypeParam>& edge) {
      typename TypeParam::Tangent d = this->ahead_;
      d(TypeParam::kDof - 1) = (edge.edge % 2 == 0 ? 1 : -1) * (gains_much ? 0.1 : 1e-4);
      return TypeParam().Plus(d);
    });
    std::int64_t edges = 0;
    this->tree_.CostAt(root, T, Inside::kMean, &edges);
    EXPECT_EQ(edges > 0, gains_much);
  }
}

// Coiled up, and at last turned by more than a term can say; with and without a tolerance.
TYPED_TEST(SettleTest, WhatLagsGoesOnLagging) {
  const bool is_flat = TypeParam::kRotationDof == 1;
  const Index root = this->Straight(is_flat ? 12 : 40);
  const auto coil = [&](const ChainEdge<TypeParam>&) {
    typename TypeParam::Tangent d = this->ahead_;
    d(TypeParam::kDof - 1) = is_flat ? 0.8 : 1.2;
    return TypeParam().Plus(d);
  };
  for (const double tolerance : {-1., 1e-3}) {
    this->tree_.LinearizeAt(root, coil);
    const SpanModel<TypeParam> before = this->tree_.Model(root);
    const bool holds = tolerance < 0 ? this->tree_.SettleAll(root, before.T, true).holds
                                     : this->tree_.Settle(root, before.T, tolerance, true).holds;
    EXPECT_FALSE(holds) << tolerance;
    EXPECT_LT(this->tree_.Model(root).cost, 0.9 * before.cost) << tolerance;
  }
}

// Linearized where it is far from its optimum, a model promises what its edges do not do.
TYPED_TEST(SettleTest, WhatIsLinearizedFarOffCostsWhatItsEdgesDo) {
  const Index root = this->Straight(12);
  this->tree_.LinearizeAt(root, [&](const ChainEdge<TypeParam>& edge) {
    typename TypeParam::Tangent d = this->ahead_;
    d(TypeParam::kDof - 1) = edge.edge % 4 < 2 ? 0.4 : -0.4;
    return TypeParam().Plus(d);
  });
  const SpanModel<TypeParam> model = this->tree_.Model(root);
  const double cost = this->Cost(root, model.T);
  EXPECT_NEAR(this->tree_.CostAt(root, model.T, Inside::kMean), cost, 1e-9 * cost);
  EXPECT_GT(model.cost - GainAt(model), 1.1 * cost);
}

// A zigzag: where a step raises its cost at last it lags, else it rests; without a tolerance.
TYPED_TEST(SettleTest, WhatLagsIsToldFromWhatRests) {
  const auto settle = [&](double turn, int period, int edges) {
    const Index root = this->Straight(edges);
    this->tree_.LinearizeAt(root, [&](const ChainEdge<TypeParam>& edge) {
      typename TypeParam::Tangent d = this->ahead_;
      d(TypeParam::kDof - 1) = edge.edge % period < period / 2 ? turn : -turn;
      return TypeParam().Plus(d);
    });
    const SpanModel<TypeParam> before = this->tree_.Model(root);
    const bool holds = this->tree_.SettleAll(root, before.T, true).holds;
    EXPECT_LT(this->tree_.Model(root).cost, 0.9 * before.cost) << "what is gained is kept";
    return holds;
  };
  EXPECT_FALSE(settle(0.8, 8, 40));
  EXPECT_TRUE(settle(0.4, 4, 12));
}

// What could not follow its ends stays where it is as long as they do, and yields to them.
TYPED_TEST(SettleTest, WhatLagsMovesWithItsEndsAlone) {
  const Index root = this->Straight(40);
  std::vector<TypeParam> crooked;
  this->tree_.LinearizeAt(root, [&](const ChainEdge<TypeParam>& edge) {
    typename TypeParam::Tangent d = this->ahead_;
    d(TypeParam::kDof - 1) = edge.edge % 2 == 0 ? 0.3 : -0.3;
    crooked.push_back(TypeParam().Plus(d));
    return crooked.back();
  });
  const TypeParam T = this->tree_.Model(root).T;
  const auto follow = [&](const TypeParam& ends, double bound) {
    TypeParam product;
    std::size_t k = 0;
    this->tree_.ForEachEdge(root, ends, Inside::kYields, [&](Index, const TypeParam& Y) {
      EXPECT_LT(Y.LocalCoordinates(crooked[k++]).norm(), bound);
      product = product * Y;
    });
    EXPECT_LT(product.LocalCoordinates(ends).norm(), 1e-9);
  };
  follow(T, 1e-9);
  follow(T.Plus(0.4 * this->ahead_), 0.02);
}

}  // namespace
}  // namespace hpgo
