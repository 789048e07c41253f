// Edges whose ends stand further from where the measurement has them than it is long.
#pragma once

#include "ceres_costs/factor_term.h"

namespace ceres_costs {

// Gauss-Newton takes the error in the frame of X_i. When X_i turns, X_j moves in that frame as far
// as it is away, t, and the model is stiff against turns that cost next to nothing: in the world's
// frame the error, (t_j - t_i) - R_i z, is as long, and only z, that of the measurement, turns.
template <typename G>
bool IsStretched(const FactorTerm<G>& factor, const G& T_i_j) {
  if (factor.custom != nullptr || factor.convention == ErrorConvention::kTwist) return false;
  const typename G::Vector z = factor.term->measurement.translation();
  return (T_i_j.translation() - z).squaredNorm() > z.squaredNorm();
}

// What takes the Gauss-Newton model of such a factor between two poses to its second derivatives
// under Retract, as far as Omega measures translation alike in all directions, and less what is
// negative: to be added to the blocks (X_i, X_i) and (X_j, X_i) of the Hessian. The sum is positive
// semi-definite, the gradient the same. With the loss's weight applied.
template <typename G>
void StretchedModel(const FactorTerm<G>& factor, const G& T_i_j, typename G::Matrix* ii,
                    typename G::Matrix* ji);

}  // namespace ceres_costs
