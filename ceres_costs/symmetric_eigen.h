// Eigenvalues of small symmetric matrices. Compiled once for all sizes: Eigen's solver takes the
// compiler seconds for each.
#pragma once

#include "Eigen/Core"

namespace ceres_costs {

template <int N>
struct SymmetricEigen {
  Eigen::Matrix<double, N, 1> values;   // ascending
  Eigen::Matrix<double, N, N> vectors;  // by columns
};

// Of an n x n matrix by columns, whose lower triangle is read. `vectors` may be null.
void DecomposeSymmetric(const double* matrix, int n, double* values, double* vectors);

// Undefined where the matrix is not finite.
template <int N>
SymmetricEigen<N> EigenOf(const Eigen::Matrix<double, N, N>& matrix) {
  SymmetricEigen<N> eigen;
  DecomposeSymmetric(matrix.data(), N, eigen.values.data(), eigen.vectors.data());
  return eigen;
}

template <int N>
Eigen::Matrix<double, N, 1> EigenvaluesOf(const Eigen::Matrix<double, N, N>& matrix) {
  Eigen::Matrix<double, N, 1> values;
  DecomposeSymmetric(matrix.data(), N, values.data(), nullptr);
  return values;
}

}  // namespace ceres_costs
