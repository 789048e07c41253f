#include "hpgo/solve/marginal.h"

#include <cmath>
#include <vector>

#include "hpgo/solve/block_system.h"

namespace hpgo {

template <typename G>
Result<typename G::Matrix> MarginalCovariance(const Subproblem<G>& problem, int index) {
  BlockSystem<G> system;
  system.Analyze(&problem);
  if (!std::isfinite(system.Linearize())) {
    return Status(StatusCode::kNoSolution, "the cost is not finite at the estimate");
  }
  if (!system.Factorize(0)) {
    return Status(StatusCode::kNoSolution, "the poses are not determined: the Hessian is singular");
  }
  typename G::Matrix covariance;
  std::vector<double> column(static_cast<std::size_t>(problem.num_free) * G::kDof);
  for (int c = 0; c < G::kDof; ++c) {
    column.assign(column.size(), 0.);
    double* block = &column[static_cast<std::size_t>(index) * G::kDof];
    block[c] = 1;
    system.Solve(column.data());
    covariance.col(c) = Eigen::Map<const typename G::Tangent>(block);
  }
  return typename G::Matrix(0.5 * (covariance + covariance.transpose()));
}

template Result<ceres_costs::SE2::Matrix> MarginalCovariance(const Subproblem<ceres_costs::SE2>&,
                                                             int);
template Result<ceres_costs::SE3::Matrix> MarginalCovariance(const Subproblem<ceres_costs::SE3>&,
                                                             int);

}  // namespace hpgo
