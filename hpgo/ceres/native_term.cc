#include "hpgo/ceres/native_term.h"

#include <cmath>

#include "Eigen/Cholesky"
#include "ceres_costs/factor_term.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
std::optional<LeastCost<G>> FindLeastCost(const ceres::CostFunction& cost, bool unary, const G& T) {
  constexpr int kIterations = 10;
  ceres_costs::FactorTerm<G> factor;
  factor.custom = &cost;
  ceres_costs::QuadraticModel<G> model, best;
  LeastCost<G> least;
  least.T = T;
  if (!LinearizeFactor(factor, unary, T, &best)) return std::nullopt;
  for (int k = 0; k < kIterations; ++k) {
    const typename G::Tangent d = best.A.ldlt().solve(-best.b);
    if (!d.allFinite()) break;
    const G next = least.T.Retract(d).Normalized();
    if (!LinearizeFactor(factor, unary, next, &model) || !(model.cost < best.cost)) break;
    const bool done = best.cost - model.cost <= 1e-9 * best.cost;
    least.T = next;
    best = model;
    if (done) break;
  }
  least.information = best.A;
  least.value = best.cost;
  return least;
}

template <typename G>
std::optional<ceres_costs::RelativePoseTerm<G>> AsTerm(const ceres::CostFunction& cost,
                                                       const LeastCost<G>& least,
                                                       ceres_costs::ErrorConvention convention) {
  constexpr double kZero = 1e-12;  // where a measurement is met
  constexpr double kSame = 1e-8;   // of the value
  if (!(least.value <= kZero)) return std::nullopt;
  const typename G::Matrix J_inverse =
      ceres_costs::DeviationJacobian(convention, G(), G::Tangent::Zero()).inverse();
  ceres_costs::RelativePoseTerm<G> term;
  term.measurement = least.T;
  term.information = ceres_costs::PackedSymmetric<G::kDof>(
      typename G::Matrix(J_inverse.transpose() * least.information * J_inverse));
  ceres_costs::FactorTerm<G> custom, native;
  custom.custom = &cost;
  native.term = &term;
  native.convention = convention;
  // All directions at once, each time another way, the turns up to 2.5 rad.
  const double sizes[][2] = {{0.1, 0.05}, {1, 0.7}, {20, 2.5}};  // m, rad
  int k = 0;
  for (const auto& [distance, angle] : sizes) {
    typename G::Tangent d;
    for (int c = 0; c < G::kDof; ++c) d(c) = std::cos(1. + 2.3 * (k += 2));
    d.template head<G::kDim>() *= distance / d.template head<G::kDim>().norm();
    d.template tail<G::kRotationDof>() *= angle / d.template tail<G::kRotationDof>().norm();
    const G T = least.T.Retract(d);
    const double value = FactorCost(custom, false, T);
    if (!(std::abs(value - FactorCost(native, false, T)) <= kSame * value)) return std::nullopt;
  }
  return term;
}

#define HPGO_INSTANTIATE(G)                                                                       \
  template std::optional<LeastCost<G>> FindLeastCost(const ceres::CostFunction&, bool, const G&); \
  template std::optional<ceres_costs::RelativePoseTerm<G>> AsTerm(                                \
      const ceres::CostFunction&, const LeastCost<G>&, ceres_costs::ErrorConvention);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
