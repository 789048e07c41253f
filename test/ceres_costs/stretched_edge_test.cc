// The model of edges that are pulled apart.

#include "ceres_costs/stretched_edge.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "ceres/loss_function.h"
#include "ceres_costs/symmetric_eigen.h"
#include "test/ceres_costs/factor_samples.h"

namespace ceres_costs {
namespace {

template <typename G>
constexpr int kBoth = 2 * G::kDof;
// Of X_i, then of X_j.
template <typename G>
using BothMatrix = Eigen::Matrix<double, kBoth<G>, kBoth<G>>;
template <typename G>
using BothTangent = Eigen::Matrix<double, kBoth<G>, 1>;

// Measured 0.4 m apart at most, and some metres off.
template <typename G>
struct Stretched {
  RelativePoseTerm<G> term;
  FactorTerm<G> factor;
  G X_i, X_j;

  Stretched(std::mt19937* rng, const typename G::Matrix& information)
      : term{RandomPose<G>(rng, 0.2), PackedSymmetric<G::kDof>(information)} {
    factor.term = &term;
    do {
      X_i = RandomPose<G>(rng, 5);
      X_j = RandomPose<G>(rng, 5);
    } while (!IsStretched(factor, T_i_j()));
  }
  Stretched(const Stretched&) = delete;  // the factor points into it
  Stretched& operator=(const Stretched&) = delete;

  G T_i_j() const { return X_i.Between(X_j); }
};

template <typename G>
BothMatrix<G> Hessian(const FactorTerm<G>& factor, const G& T_i_j) {
  QuadraticModel<G> at_j, at_i;
  typename G::Matrix cross, ii, ji;
  EXPECT_TRUE(LinearizeFactor(factor, false, T_i_j, &at_j));
  TransportModel(T_i_j.Inverse(), at_j, &at_i, &cross);
  StretchedModel(factor, T_i_j, &ii, &ji);
  BothMatrix<G> H;
  H << at_i.A + ii, (ji - cross).transpose(), ji - cross, at_j.A;
  return H;
}

// One that measures translation alone, alike in all directions.
template <typename G>
typename G::Matrix Alike(double k) {
  typename G::Matrix information = G::Matrix::Zero();
  information.diagonal().template head<G::kDim>().setConstant(k);
  return information;
}

// Half the second derivatives of the cost, by numeric differentiation.
template <typename G>
BothMatrix<G> SecondDerivatives(const Stretched<G>& edge) {
  const auto cost = [&](const BothTangent<G>& d) {
    const typename G::Tangent d_i = d.template head<G::kDof>(), d_j = d.template tail<G::kDof>();
    return FactorCost(edge.factor, false, edge.X_i.Retract(d_i).Between(edge.X_j.Retract(d_j)));
  };
  const double h = 1e-3;
  BothMatrix<G> H;
  for (int r = 0; r < kBoth<G>; ++r) {
    for (int c = 0; c < kBoth<G>; ++c) {
      const BothTangent<G> a = h * BothTangent<G>::Unit(r), b = h * BothTangent<G>::Unit(c);
      H(r, c) = (cost(a + b) - cost(a - b) - cost(b - a) + cost(-a - b)) / (8 * h * h);
    }
  }
  return H;
}

template <typename G>
class StretchedEdgeTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(StretchedEdgeTest, Groups);

TYPED_TEST(StretchedEdgeTest, HasTheSecondDerivativesOfOneThatIsPulledOut) {
  using G = TypeParam;
  std::mt19937 rng(1);
  for (int k = 0; k < 50; ++k) {
    Stretched<G> edge(&rng, Alike<G>(1 + k));
    edge.factor.convention = k % 2 == 0 ? ErrorConvention::kG2o : ErrorConvention::kSplitLog;
    edge.X_j.translation() = edge.X_i * typename G::Vector(5 * edge.term.measurement.translation());
    const BothMatrix<G> expected = SecondDerivatives(edge);
    const double scale = expected.cwiseAbs().maxCoeff();
    EXPECT_TRUE(IsNear(Hessian(edge.factor, edge.T_i_j()), expected, 1e-5 * scale)) << k;
  }
}

TYPED_TEST(StretchedEdgeTest, LeavesOutOnlyWhatIsNegative) {
  using G = TypeParam;
  std::mt19937 rng(2);
  for (int k = 0; k < 50; ++k) {
    const Stretched<G> edge(&rng, Alike<G>(1 + k));
    const BothMatrix<G> H = Hessian(edge.factor, edge.T_i_j()), exact = SecondDerivatives(edge);
    const double scale = exact.cwiseAbs().maxCoeff();
    EXPECT_GT(EigenvaluesOf<kBoth<G>>(H - exact)(0), -1e-5 * scale) << k;
    EXPECT_GT(EigenvaluesOf(H)(0), -1e-9 * scale) << k;
  }
}

TYPED_TEST(StretchedEdgeTest, HasTheWeightOfTheLoss) {
  using G = TypeParam;
  std::mt19937 rng(3);
  const ceres::HuberLoss huber(1);
  Stretched<G> edge(&rng, Alike<G>(4));
  const double chi2 = FactorCost(edge.factor, false, edge.T_i_j());
  ASSERT_GT(chi2, 4);
  typename G::Matrix ii, ji, weighted_ii, weighted_ji;
  StretchedModel(edge.factor, edge.T_i_j(), &ii, &ji);
  edge.factor.loss = &huber;
  StretchedModel(edge.factor, edge.T_i_j(), &weighted_ii, &weighted_ji);
  EXPECT_TRUE(IsNear(std::sqrt(chi2) * weighted_ii, ii, 1e-9 * ii.norm()));
  EXPECT_TRUE(IsNear(std::sqrt(chi2) * weighted_ji, ji, 1e-9 * ji.norm()));
}

// Whatever couples translation and rotation, and what nothing measures.
TYPED_TEST(StretchedEdgeTest, IsSemiDefinite) {
  using G = TypeParam;
  std::mt19937 rng(4);
  for (int k = 0; k < 200; ++k) {
    const int rank = k % (G::kDof + 1);
    const Stretched<G> edge(&rng, RandomInformation<G::kDof>(&rng, rank));
    const BothMatrix<G> H = Hessian(edge.factor, edge.T_i_j());
    const double scale = std::max(1., H.cwiseAbs().maxCoeff());
    EXPECT_TRUE(IsNear(H, H.transpose(), 1e-12 * scale)) << k;
    EXPECT_GT(EigenvaluesOf(H)(0), -1e-9 * scale) << k;
  }
}

TYPED_TEST(StretchedEdgeTest, IsForThoseOnlyWhoseErrorIsLongerThanTheMeasurement) {
  using G = TypeParam;
  typename G::Tangent d = G::Tangent::Zero();
  d(0) = 2;
  const RelativePoseTerm<G> term{G().Retract(d), {}};
  FactorTerm<G> factor;
  factor.term = &term;
  const auto at = [&](double x) {
    d(0) = x;
    return IsStretched(factor, G().Retract(d));
  };
  EXPECT_FALSE(at(3.9));
  EXPECT_TRUE(at(4.1));
  EXPECT_TRUE(at(-0.1));
  EXPECT_FALSE(at(0.1));
  factor.convention = ErrorConvention::kTwist;  // of another length in the world's frame
  EXPECT_FALSE(at(4.1));
}

}  // namespace
}  // namespace ceres_costs
