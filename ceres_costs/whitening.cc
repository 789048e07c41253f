#include "ceres_costs/whitening.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"

namespace ceres_costs {
namespace {

constexpr double kProjectionFloor = 1e-9;  // of the largest eigenvalue

template <int N>
using SquareMatrix = Eigen::Matrix<double, N, N>;

template <int N>
bool UpperTriangleIsFinite(const SquareMatrix<N>& m) {
  return SquareMatrix<N>(m.template triangularView<Eigen::Upper>()).allFinite();
}

// Eigen's decompositions read the lower triangle.
template <int N>
Eigen::SelfAdjointEigenSolver<SquareMatrix<N>> Decompose(const SquareMatrix<N>& m, int options) {
  return Eigen::SelfAdjointEigenSolver<SquareMatrix<N>>(m.transpose(), options);
}

// Of finite matrices.
template <int N>
bool IsIndefinite(const SquareMatrix<N>& m, double tolerance) {
  const Eigen::Matrix<double, N, 1> values = Decompose<N>(m, Eigen::EigenvaluesOnly).eigenvalues();
  return values(0) < -tolerance * std::max(std::abs(values(0)), std::abs(values(N - 1)));
}

}  // namespace

template <int N>
InformationKind ClassifyInformation(const Eigen::Matrix<double, N, N>& information,
                                    double tolerance) {
  if (!UpperTriangleIsFinite<N>(information)) return InformationKind::kNotFinite;
  // The trace bounds the largest eigenvalue of a semi-definite matrix, so a Cholesky factorization
  // of the shifted matrix proves the common case without eigenvalues.
  const SquareMatrix<N> shifted =
      information - SquareMatrix<N>::Identity() * (tolerance * information.trace());
  if (Eigen::LLT<SquareMatrix<N>, Eigen::Upper>(shifted).info() == Eigen::Success) {
    return InformationKind::kPositiveDefinite;
  }
  const EigenvalueRange range = InformationEigenvalues<N>(information);
  const double zero = tolerance * std::max(std::abs(range.min), std::abs(range.max));
  if (range.min < -zero) return InformationKind::kIndefinite;
  return range.min > zero ? InformationKind::kPositiveDefinite : InformationKind::kSemiDefinite;
}

template <int N>
EigenvalueRange InformationEigenvalues(const Eigen::Matrix<double, N, N>& information) {
  if (!UpperTriangleIsFinite<N>(information)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  const auto values = Decompose<N>(information, Eigen::EigenvaluesOnly).eigenvalues();
  return {values(0), values(N - 1)};
}

template <int N>
bool WhitenInformation(const Eigen::Matrix<double, N, N>& information,
                       Eigen::Matrix<double, N, N>* W) {
  if (!UpperTriangleIsFinite<N>(information)) return false;
  const Eigen::LLT<SquareMatrix<N>, Eigen::Upper> llt(information);
  if (llt.info() == Eigen::Success) {
    *W = llt.matrixU();
    return true;
  }
  if (IsIndefinite<N>(information, kInformationTolerance)) return false;
  // Scaled to a unit diagonal, so that the digits of weak directions do not drown in those of
  // strong ones (metres and radians share the matrix).
  Eigen::Matrix<double, N, 1> scale, inverse_scale;
  for (int k = 0; k < N; ++k) {
    scale(k) = std::sqrt(std::max(information(k, k), 0.0));
    inverse_scale(k) = scale(k) > 0 ? 1 / scale(k) : 0;
  }
  const SquareMatrix<N> scaled =
      inverse_scale.asDiagonal() * information * inverse_scale.asDiagonal();
  const auto eigen = Decompose<N>(scaled, Eigen::ComputeEigenvectors);
  const double noise = N * std::numeric_limits<double>::epsilon() * eigen.eigenvalues()(N - 1);
  Eigen::Matrix<double, N, 1> roots;
  for (int k = 0; k < N; ++k) {
    const double value = eigen.eigenvalues()(k);
    roots(k) = value > noise ? std::sqrt(value) : 0;
  }
  *W = roots.asDiagonal() * eigen.eigenvectors().transpose() * scale.asDiagonal();
  return true;
}

template <int N>
Eigen::Matrix<double, N, N> ProjectInformation(const Eigen::Matrix<double, N, N>& information) {
  const auto eigen = Decompose<N>(information, Eigen::ComputeEigenvectors);
  const double largest = eigen.eigenvalues()(N - 1);
  if (largest <= 0) return SquareMatrix<N>::Zero();
  const Eigen::Matrix<double, N, 1> values =
      eigen.eigenvalues().cwiseMax(kProjectionFloor * largest);
  const SquareMatrix<N> m =
      eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose();
  return 0.5 * (m + m.transpose());
}

#define CERES_COSTS_INSTANTIATE(N)                                                             \
  template InformationKind ClassifyInformation<N>(const Eigen::Matrix<double, N, N>&, double); \
  template EigenvalueRange InformationEigenvalues<N>(const Eigen::Matrix<double, N, N>&);      \
  template bool WhitenInformation<N>(const Eigen::Matrix<double, N, N>&,                       \
                                     Eigen::Matrix<double, N, N>*);                            \
  template Eigen::Matrix<double, N, N> ProjectInformation<N>(const Eigen::Matrix<double, N, N>&);
CERES_COSTS_INSTANTIATE(2)
CERES_COSTS_INSTANTIATE(3)
CERES_COSTS_INSTANTIATE(6)
#undef CERES_COSTS_INSTANTIATE

}  // namespace ceres_costs
