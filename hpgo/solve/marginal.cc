#include "hpgo/solve/marginal.h"

#include <cmath>

#include "hpgo/solve/block_system.h"

namespace hpgo {
namespace {

Status NotDetermined() {
  return Status(StatusCode::kNoSolution, "the poses are not determined: the Hessian is singular");
}

Result<Eigen::MatrixXd> InRange(const Eigen::MatrixXd& covariance) {
  if (covariance.allFinite()) return covariance;
  return Status(StatusCode::kNoSolution, "the covariance leaves the range of a double");
}

// The columns of the inverse, by the factor that `system` holds, and their rows at `indices`.
template <typename G>
Eigen::MatrixXd Columns(const BlockSystem<G>& system, int num_free,
                        const std::vector<int>& indices) {
  constexpr int D = G::kDof;
  const int n = static_cast<int>(indices.size());
  Eigen::MatrixXd covariance(n * D, n * D);
  std::vector<double> column(static_cast<std::size_t>(num_free) * D);
  const auto block = [&](int k) {
    return Eigen::Map<typename G::Tangent>(&column[static_cast<std::size_t>(indices[k]) * D]);
  };
  for (int c = 0; c < n * D; ++c) {
    column.assign(column.size(), 0.);
    block(c / D)(c % D) = 1;
    system.Solve(column.data());
    for (int k = 0; k < n; ++k) covariance.template block<D, 1>(k * D, c) = block(k);
  }
  return 0.5 * (covariance + covariance.transpose());
}

}  // namespace

template <typename G>
Result<Eigen::MatrixXd> JointCovariance(const Subproblem<G>& problem,
                                        const std::vector<int>& indices) {
  // Where the Hessian is singular, what it determines has the same covariance at any small damping,
  // to first order in that; the rest grows with its inverse.
  constexpr double kDamping = 1e-9, kMoreDamping = 1e-8, kSame = 1e-3;
  BlockSystem<G> system;
  system.Analyze(&problem);
  if (!std::isfinite(system.Linearize(Hessian::kAsMeasured))) {
    return Status(StatusCode::kNoSolution, "the cost is not finite at the estimate");
  }
  if (system.Factorize(0)) return InRange(Columns(system, problem.num_free, indices));
  bool measured = true;
  for (int node = 0; node < problem.num_free; ++node) {
    for (int d = 0; d < G::kDof; ++d) {
      if (system.Diagonal(node)(d, d) > 0) continue;
      // Nothing measures this coordinate, so that its row is zero. Any value keeps it apart.
      system.Diagonal(node)(d, d) = 1;
      for (const int index : indices) measured &= index != node;
    }
  }
  if (!measured || !system.Factorize(kMoreDamping)) return NotDetermined();
  const Eigen::MatrixXd more = Columns(system, problem.num_free, indices);
  if (!system.Factorize(kDamping)) return NotDetermined();
  const Eigen::MatrixXd less = Columns(system, problem.num_free, indices);
  const Eigen::MatrixXd difference = less - more;
  for (int k = 0; k < static_cast<int>(less.rows()); ++k) {
    if (!(std::abs(difference(k, k)) <= kSame * less(k, k))) return NotDetermined();
  }
  return InRange(less + difference * (kDamping / (kMoreDamping - kDamping)));
}

template <typename G>
Result<typename G::Matrix> MarginalCovariance(const Subproblem<G>& problem, int index) {
  const Result<Eigen::MatrixXd> joint = JointCovariance(problem, {index});
  if (!joint.ok()) return joint.status();
  return typename G::Matrix(*joint);
}

template Result<Eigen::MatrixXd> JointCovariance(const Subproblem<ceres_costs::SE2>&,
                                                 const std::vector<int>&);
template Result<Eigen::MatrixXd> JointCovariance(const Subproblem<ceres_costs::SE3>&,
                                                 const std::vector<int>&);
template Result<Eigen::MatrixXd> JointCovariance(const Subproblem<ceres_costs::YawPose>&,
                                                 const std::vector<int>&);
template Result<ceres_costs::SE2::Matrix> MarginalCovariance(const Subproblem<ceres_costs::SE2>&,
                                                             int);
template Result<ceres_costs::SE3::Matrix> MarginalCovariance(const Subproblem<ceres_costs::SE3>&,
                                                             int);
template Result<ceres_costs::YawPose::Matrix> MarginalCovariance(
    const Subproblem<ceres_costs::YawPose>&, int);

}  // namespace hpgo
