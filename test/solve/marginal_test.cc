#include "hpgo/solve/marginal.h"

#include <cmath>

#include "Eigen/LU"
#include "gtest/gtest.h"
#include "small_graphs.h"
#include "small_problems.h"

namespace hpgo {
namespace {

template <typename G>
class MarginalTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(MarginalTest, Groups);

// H = sum J' Omega J by numeric derivatives of the whitened errors.
template <typename G>
Eigen::MatrixXd NumericHessian(const Subproblem<G>& problem) {
  constexpr int D = G::kDof;
  const double h = 1e-6;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(problem.num_free * D, problem.num_free * D);
  for (const Factor<G>& factor : problem.factors) {
    const auto error = [&](const std::vector<G>& poses) {
      const G T =
          factor.i == kWorldFrame ? poses[factor.j] : poses[factor.i].Inverse() * poses[factor.j];
      return typename G::Tangent(
          ceres_costs::DeviationError(factor.convention, factor.term->measurement.Inverse() * T));
    };
    Eigen::Matrix<double, D, Eigen::Dynamic> J(D, H.cols());
    J.setZero();
    for (int node : {factor.i, factor.j}) {
      for (int c = 0; node != kWorldFrame && node < problem.num_free && c < D; ++c) {
        std::vector<G> ahead = problem.poses, behind = problem.poses;
        ahead[node] = ahead[node].Retract(h * G::Tangent::Unit(c));
        behind[node] = behind[node].Retract(-h * G::Tangent::Unit(c));
        J.col(node * D + c) = (error(ahead) - error(behind)) / (2 * h);
      }
    }
    H += J.transpose() * factor.term->information.Dense() * J;
  }
  return H;
}

template <typename G>
void ExpectBlocksOfTheInverse(const Subproblem<G>& problem) {
  constexpr int D = G::kDof;
  const Eigen::MatrixXd inverse = NumericHessian(problem).inverse();
  const double scale = inverse.cwiseAbs().maxCoeff();
  for (int k = 0; k < problem.num_free; ++k) {
    const Result<typename G::Matrix> covariance = MarginalCovariance(problem, k);
    ASSERT_TRUE(covariance.ok()) << covariance.status().ToString();
    const Eigen::MatrixXd expected = inverse.block(k * D, k * D, D, D);
    EXPECT_LE((*covariance - expected).cwiseAbs().maxCoeff(), 1e-6 * scale) << k;
    EXPECT_EQ(*covariance, covariance->transpose());
  }
}

TYPED_TEST(MarginalTest, IsABlockOfTheInverseHessian) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Problem<TypeParam> problem(MakeKnownGraph<TypeParam>(25, 0.05, seed).graph);
    ExpectBlocksOfTheInverse(problem.subproblem);
  }
}

TYPED_TEST(MarginalTest, SeveralConstantPosesAndAPrior) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(25, 0.05, 7).graph);
  problem.subproblem.num_free = 20;
  std::mt19937_64 rng(7);
  problem.terms.push_back(  // within what it reserved
      {problem.subproblem.poses[3],
       ceres_costs::PackedSymmetric<G::kDof>(RandomInformation<G>(&rng))});
  Factor<G> prior;
  prior.j = 3;
  prior.term = &problem.terms.back();
  problem.subproblem.factors.push_back(prior);
  ExpectBlocksOfTheInverse(problem.subproblem);
  problem.subproblem.num_free = 25;  // the prior alone holds it
  ExpectBlocksOfTheInverse(problem.subproblem);
}

// One measurement from a pose that is known: its covariance, carried to the end of the edge.
TYPED_TEST(MarginalTest, OfOneMeasurementItIsItsCovariance) {
  using G = TypeParam;
  std::mt19937_64 rng(8);
  const typename G::Matrix information = RandomInformation<G>(&rng);
  const G X = RandomPose<G>(&rng, 3, 2), Z = RandomPose<G>(&rng, 3, 2);
  const ceres_costs::RelativePoseTerm<G> term = {
      Z, ceres_costs::PackedSymmetric<G::kDof>(information)};
  Subproblem<G> problem;
  problem.poses = {X * Z, X};
  problem.num_free = 1;
  Factor<G> factor;
  factor.term = &term;
  factor.i = 1;
  factor.j = 0;
  factor.convention = ceres_costs::ErrorConvention::kSplitLog;
  problem.factors.push_back(factor);
  const Result<typename G::Matrix> covariance = MarginalCovariance(problem, 0);
  ASSERT_TRUE(covariance.ok()) << covariance.status().ToString();
  EXPECT_LE((*covariance - information.inverse()).cwiseAbs().maxCoeff(), 1e-12);
}

TYPED_TEST(MarginalTest, AFreeGaugeHasNone) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(10, 0.05, 9).graph);
  problem.subproblem.num_free = 10;
  const Result<typename G::Matrix> covariance = MarginalCovariance(problem.subproblem, 4);
  ASSERT_FALSE(covariance.ok());
  EXPECT_EQ(covariance.status().code(), StatusCode::kNoSolution);
  EXPECT_EQ(covariance.status().message(), "the poses are not determined: the Hessian is singular");
}

TYPED_TEST(MarginalTest, AnUnmeasuredDirectionHasNone) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(10, 0.05, 9).graph);
  problem.subproblem.poses.insert(problem.subproblem.poses.begin() + 9, G());  // without a factor
  for (Factor<G>& factor : problem.subproblem.factors) {
    factor.i += factor.i == 9;
    factor.j += factor.j == 9;
  }
  problem.subproblem.num_free = 10;
  const Result<typename G::Matrix> covariance = MarginalCovariance(problem.subproblem, 9);
  ASSERT_FALSE(covariance.ok());
  EXPECT_EQ(covariance.status().code(), StatusCode::kNoSolution);
}

TYPED_TEST(MarginalTest, AnEstimateThatIsNotFiniteHasNone) {
  using G = TypeParam;
  Problem<G> problem(MakeKnownGraph<G>(10, 0.05, 9).graph);
  problem.subproblem.poses[2].translation()(0) = std::nan("");
  const Result<typename G::Matrix> covariance = MarginalCovariance(problem.subproblem, 4);
  ASSERT_FALSE(covariance.ok());
  EXPECT_EQ(covariance.status().code(), StatusCode::kNoSolution);
  EXPECT_EQ(covariance.status().message(), "the cost is not finite at the estimate");
}

}  // namespace
}  // namespace hpgo
