// One summand rho(e' Omega e) of a pose graph's objective, and its local quadratic model. What the
// coarse edges, the stress and the block solver are computed from.
#pragma once

#include "ceres/cost_function.h"
#include "ceres/loss_function.h"
#include "ceres_costs/relative_pose_error.h"

namespace ceres_costs {

// `custom` replaces the cost of `term` where it is set; one of them is. Owns nothing.
template <typename G>
struct FactorTerm {
  const RelativePoseTerm<G>* term = nullptr;
  ErrorConvention convention = ErrorConvention::kG2o;
  const G* offset = nullptr;  // of a prior: P = T_node_sensor, e of Z^-1 X P; null is the identity
  // Any Ceres cost over the parameter blocks {X_i, X_j}, or {X_j} for a prior, in the storage order
  // of G, with Jacobians by the stored parameters; its residuals are whitened. One over two poses
  // must depend on X_i^-1 X_j only.
  const ceres::CostFunction* custom = nullptr;
  const ceres::LossFunction* loss = nullptr;  // null: squared
};

// The model of a factor at T_i_j under a right perturbation d of X_j:
// cost + 2 b'd + d'A d, with the loss's weight applied.
template <typename G>
struct QuadraticModel {
  typename G::Matrix A = G::Matrix::Zero();
  typename G::Tangent b = G::Tangent::Zero();
  double cost = 0;
};

// rho(e' Omega e) at T_i_j = X_i^-1 X_j; for a prior (`unary`) T_i_j = T_world_j. NaN where a
// custom cost fails.
template <typename G>
double FactorCost(const FactorTerm<G>& factor, bool unary, const G& T_i_j);

// As FactorCost, with the model. False where a custom cost fails.
template <typename G>
bool LinearizeFactor(const FactorTerm<G>& factor, bool unary, const G& T_i_j,
                     QuadraticModel<G>* model);

// The change of the whitened error from T0 to T1, sqrt((e1 - e0)' Omega (e1 - e0)), weighted by the
// loss at T1. Zero where a custom cost fails.
template <typename G>
double FactorChange(const FactorTerm<G>& factor, bool unary, const G& T0, const G& T1);

// M' A M and M' b for M = Ad(T) and, unless `AM` is null, A M.
template <typename G>
void TransportModel(const G& T, const QuadraticModel<G>& in, QuadraticModel<G>* out,
                    typename G::Matrix* AM = nullptr);

}  // namespace ceres_costs
