// Factors of every kind, and what their models should be, for the tests of factor_term.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "ceres_costs/factor_term.h"
#include "ceres_costs/losses.h"
#include "gtest/gtest.h"
#include "test/ceres_costs/samples.h"

namespace ceres_costs {

inline constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kTwist,
                                                   ErrorConvention::kSplitLog};

// rho(s) = s + s^2 / 2: grows faster than the square, its second derivative is 1.
class GrowingLoss final : public ceres::LossFunction {
 public:
  void Evaluate(double s, double rho[3]) const override {
    rho[0] = s + s * s / 2;
    rho[1] = 1 + s;
    rho[2] = 1;
  }
};

inline std::vector<std::unique_ptr<ceres::LossFunction>> Losses() {
  std::vector<std::unique_ptr<ceres::LossFunction>> losses(1);  // none
  for (const char* name : {"huber", "cauchy", "tukey", "geman_mcclure", "dcs"}) {
    std::string error;
    EXPECT_TRUE(MakeLoss(name, 0.8, &losses.emplace_back(), &error)) << error;
  }
  losses.push_back(std::make_unique<GrowingLoss>());
  return losses;
}

template <typename G>
double Scale(const QuadraticModel<G>& model) {
  return 1 + std::abs(model.cost) + model.A.cwiseAbs().maxCoeff() + model.b.cwiseAbs().maxCoeff();
}

template <typename G>
testing::AssertionResult IsSameModel(const QuadraticModel<G>& a, const QuadraticModel<G>& b,
                                     double tolerance) {
  const double absolute = tolerance * Scale(b);
  if (!(std::abs(a.cost - b.cost) <= absolute)) {
    return testing::AssertionFailure() << "cost " << a.cost << " against " << b.cost;
  }
  const testing::AssertionResult vector = IsNear(a.b, b.b, absolute);
  if (!vector) return vector;
  return IsNear(a.A, b.A, absolute);
}

// The error from its definition, e(Z^-1 T P).
template <typename G>
typename G::Tangent ErrorAt(const FactorTerm<G>& factor, const G& T) {
  const G P = factor.offset == nullptr ? G() : *factor.offset;
  return DeviationError(factor.convention, factor.term->measurement.Inverse() * T * P);
}

// The model from numeric derivatives of the error.
template <typename G>
QuadraticModel<G> NumericModel(const FactorTerm<G>& factor, const G& T) {
  const double h = 1e-5;
  typename G::Matrix J;
  for (int k = 0; k < G::kDof; ++k) {
    const typename G::Tangent step = h * G::Tangent::Unit(k);
    J.col(k) = (ErrorAt(factor, T.Retract(step)) - ErrorAt<G>(factor, T.Retract(-step))) / (2 * h);
  }
  const typename G::Matrix omega = factor.term->information.Dense();
  const typename G::Tangent e = ErrorAt(factor, T);
  QuadraticModel<G> model;
  model.A = J.transpose() * omega * J;
  model.b = J.transpose() * omega * e;
  model.cost = e.dot(omega * e);
  if (factor.loss == nullptr) return model;
  double rho[3];
  factor.loss->Evaluate(model.cost, rho);
  model.A = rho[1] * model.A +
            2 * std::max(0., rho[2]) * typename G::Matrix(model.b * model.b.transpose());
  model.b *= rho[1];
  model.cost = rho[0];
  return model;
}

// Terms, offsets and relative poses at which they are evaluated: the deviation is of every size,
// errors are about one so that losses matter.
template <typename G>
struct Sample {
  RelativePoseTerm<G> term;
  G offset;
  G T_i_j;
};

template <typename G>
std::vector<Sample<G>> MakeSamples() {
  std::mt19937 rng(5);
  std::vector<Sample<G>> samples;
  for (const double angle : {0.0, 1e-9, 1e-4, 0.05, 0.7, 2.5, -2.9}) {
    for (const double distance : {0.0, 0.1, 3.0}) {
      const auto xi = MakeTangent(static_cast<const G*>(nullptr), distance, angle);
      const G T = RandomPose<G>(&rng, 4), P = RandomPose<G>(&rng, 2);
      const int rank = samples.size() % 4 == 3 ? G::kDim : G::kDof;
      const typename G::Matrix information = RandomInformation<G::kDof>(&rng, rank);
      samples.push_back(
          {{T * P * G::Exp(xi).Inverse(), PackedSymmetric<G::kDof>(information)}, P, T});
    }
  }
  return samples;
}

// Calls check(factor, unary, T_i_j, label) for every combination of sample, convention, loss and,
// for priors, offset.
template <typename G, typename Check>
void ForEveryFactor(const Check& check) {
  const auto losses = Losses();
  for (const Sample<G>& sample : MakeSamples<G>()) {
    for (const ErrorConvention convention : kConventions) {
      for (std::size_t k = 0; k < losses.size(); ++k) {
        FactorTerm<G> factor;
        factor.term = &sample.term;
        factor.convention = convention;
        factor.loss = losses[k].get();
        const std::string label = "convention " + std::to_string(static_cast<int>(convention)) +
                                  ", loss " + std::to_string(k);
        // Without the offset the deviation is a random one.
        check(factor, false, sample.T_i_j, label + ", edge");
        check(factor, true, sample.T_i_j, label + ", prior");
        factor.offset = &sample.offset;
        check(factor, true, sample.T_i_j, label + ", prior with an offset");
        if (testing::Test::HasFailure()) return;
      }
    }
  }
}

}  // namespace ceres_costs
