#include "hpgo/hierarchy/coarse_edge.h"

#include <random>

#include "ceres_costs/whitening.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ceres_costs::QuadraticModel;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
class CoarseEdgeTest : public testing::Test {
 protected:
  using Tangent = typename G::Tangent;

  Tangent RandomTangent(double size) {
    std::uniform_real_distribution<double> uniform(-size, size);
    Tangent d;
    for (int k = 0; k < G::kDof; ++k) d(k) = uniform(rng_);
    return d;
  }

  std::mt19937 rng_{7};
};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(CoarseEdgeTest, Groups);

// A measurement of some directions, carried through many frames, gathers rounding beside the zeros
// of the others. The Ceres engine whitens what is made of it.
TYPED_TEST(CoarseEdgeTest, APartialMeasurementStaysSemiDefinite) {
  using G = TypeParam;
  using Matrix = typename G::Matrix;
  for (int trial = 0; trial < 5000; ++trial) {
    QuadraticModel<G> model;
    std::uniform_int_distribution<int> coin(0, 1);
    for (int k = 0; k < G::kDof; ++k) model.A(k, k) = coin(this->rng_) * (k < G::kDim ? 100 : 1e6);
    model.b = model.A * this->RandomTangent(1e-3);
    G way;
    for (int step = 0; step < 4; ++step) {
      QuadraticModel<G> moved;
      // Small turns leave small entries beside the large ones.
      typename G::Tangent d = this->RandomTangent(5);
      d.template tail<G::kRotationDof>() *= std::pow(10., -3 * step);
      const G T = step == 3 ? way.Inverse() : G::Exp(d);
      way = way * T;
      TransportModel(T, model, &moved);
      model = moved;
    }
    const auto term =
        TermFromModel(model, SemiDefiniteInverse<G>(model.A), G::Exp(this->RandomTangent(1)));
    Matrix W;
    const Matrix information = term.information.Dense();
    ASSERT_TRUE(ceres_costs::WhitenInformation<G::kDof>(information, &W))
        << "trial " << trial << ":\n"
        << information;
    EXPECT_NEAR((W.transpose() * W - information).norm(), 0, 1e-9 * information.norm());
  }
}

TYPED_TEST(CoarseEdgeTest, TheRootSquaredIsTheMatrix) {
  using G = TypeParam;
  using Matrix = typename G::Matrix;
  const Matrix M = Matrix::Random();
  Matrix A = M.transpose() * M;
  A.row(1).setZero();
  A.col(1).setZero();
  const Matrix W = SemiDefiniteInverse<G>(A).Root();
  EXPECT_NEAR((W.transpose() * W - A).norm(), 0, 1e-12 * A.norm());
}

}  // namespace
}  // namespace hpgo
