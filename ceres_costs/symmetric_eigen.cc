#include "ceres_costs/symmetric_eigen.h"

#include "Eigen/Eigenvalues"

namespace ceres_costs {

void DecomposeSymmetric(const double* matrix, int n, double* values, double* vectors) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(
      Eigen::Map<const Eigen::MatrixXd>(matrix, n, n),
      vectors == nullptr ? Eigen::EigenvaluesOnly : Eigen::ComputeEigenvectors);
  Eigen::Map<Eigen::VectorXd>(values, n) = eigen.eigenvalues();
  if (vectors != nullptr) Eigen::Map<Eigen::MatrixXd>(vectors, n, n) = eigen.eigenvectors();
}

}  // namespace ceres_costs
