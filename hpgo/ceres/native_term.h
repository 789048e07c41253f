// Costs of somebody's problem that are, whatever their code, a measurement of a relative pose.
#pragma once

#include <optional>

#include "ceres/cost_function.h"
#include "ceres_costs/relative_pose_error.h"

namespace hpgo {

// Where a cost is least, found from a start.
template <typename G>
struct LeastCost {
  G T;  // T_i_j, T_world_j for a prior
  // J' J of its residuals there, under a right perturbation of T.
  typename G::Matrix information = G::Matrix::Zero();
  double value = 0;  // the squared norm of its residuals there
};
// `cost` is one as FactorTerm::custom. Nothing where it cannot be evaluated.
template <typename G>
std::optional<LeastCost<G>> FindLeastCost(const ceres::CostFunction& cost, bool unary, const G& T);

// The term e' Omega e in the convention whose value is that of the cost, as it shows at some poses
// near and far: it then is the same objective, and can be condensed into a chain. Nothing if there
// is none. For costs over two poses.
template <typename G>
std::optional<ceres_costs::RelativePoseTerm<G>> AsTerm(const ceres::CostFunction& cost,
                                                       const LeastCost<G>& least,
                                                       ceres_costs::ErrorConvention convention);

}  // namespace hpgo
