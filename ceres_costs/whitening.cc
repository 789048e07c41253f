#include "ceres_costs/whitening.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "Eigen/Cholesky"
#include "ceres_costs/symmetric_eigen.h"

namespace ceres_costs {
namespace {

constexpr double kProjectionFloor = 1e-9;  // of the largest eigenvalue

template <int N>
using SquareMatrix = Eigen::Matrix<double, N, N>;

template <int N>
bool UpperTriangleIsFinite(const SquareMatrix<N>& m) {
  return SquareMatrix<N>(m.template triangularView<Eigen::Upper>()).allFinite();
}

template <int N>
struct UnitDiagonal {
  // Roots of the diagonal; 0 where nothing is measured.
  Eigen::Matrix<double, N, 1> scale = Eigen::Matrix<double, N, 1>::Zero();
  SquareMatrix<N> matrix = SquareMatrix<N>::Zero();  // scaled; zero in rows of scale 0
  bool indefinite = false;                           // as a minor of 1 x 1 or 2 x 2 shows
};

// Of a finite matrix.
template <int N>
UnitDiagonal<N> ScaleToUnitDiagonal(const SquareMatrix<N>& m, double tolerance) {
  UnitDiagonal<N> result;
  const SquareMatrix<N> full = m.template selfadjointView<Eigen::Upper>();
  const Eigen::Matrix<double, N, 1> roots = full.diagonal().cwiseMax(0).cwiseSqrt();
  const auto fits = [&](int r, int c) {
    return r == c ? full(r, r) >= 0 : std::abs(full(r, c)) <= (1 + tolerance) * roots(r) * roots(c);
  };
  const double noise = N * std::numeric_limits<double>::epsilon() * full.cwiseAbs().maxCoeff();
  bool is_noise[N];
  for (int r = 0; r < N; ++r) {
    bool row_fits = true;
    for (int c = 0; c < N; ++c) row_fits = row_fits && fits(r, c);
    is_noise[r] = !row_fits && full.row(r).cwiseAbs().maxCoeff() <= noise;
    result.scale(r) = is_noise[r] ? 0 : roots(r);
  }
  for (int r = 0; r < N; ++r) {
    for (int c = 0; c < N; ++c) {
      if (is_noise[r] || is_noise[c]) continue;
      result.indefinite |= !fits(r, c);
      if (roots(r) > 0 && roots(c) > 0) result.matrix(r, c) = full(r, c) / roots(r) / roots(c);
    }
  }
  return result;
}

}  // namespace

template <int N>
InformationKind ClassifyInformation(const Eigen::Matrix<double, N, N>& information,
                                    double tolerance) {
  if (!UpperTriangleIsFinite<N>(information)) return InformationKind::kNotFinite;
  // A Cholesky factorization of the matrix less its scaled tolerance proves the common case without
  // eigenvalues.
  SquareMatrix<N> less = information;
  less.diagonal() *= 1 - tolerance;
  if (Eigen::LLT<SquareMatrix<N>, Eigen::Upper>(less).info() == Eigen::Success) {
    return InformationKind::kPositiveDefinite;
  }
  const UnitDiagonal<N> unit = ScaleToUnitDiagonal<N>(information, tolerance);
  if (unit.indefinite) return InformationKind::kIndefinite;
  const double smallest = InformationEigenvalues<N>(unit.matrix).min;
  if (smallest < -tolerance) return InformationKind::kIndefinite;
  return smallest > tolerance ? InformationKind::kPositiveDefinite : InformationKind::kSemiDefinite;
}

template <int N>
std::string InformationProblem(const Eigen::Matrix<double, N, N>& information) {
  const InformationKind kind = ClassifyInformation<N>(information);
  if (kind == InformationKind::kNotFinite) return "information is not finite";
  if (kind != InformationKind::kIndefinite) return "";
  std::ostringstream message;
  message << "information is not positive semi-definite";
  const EigenvalueRange range = InformationEigenvalues<N>(information);
  if (range.min < -1e-12 * range.max) {
    message << ", smallest eigenvalue " << range.min;
  } else {  // it drowns in the digits of the largest
    message << " beside its largest eigenvalue " << range.max;
  }
  return message.str();
}

template <int N>
EigenvalueRange InformationEigenvalues(const Eigen::Matrix<double, N, N>& information) {
  if (!UpperTriangleIsFinite<N>(information)) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    return {nan, nan};
  }
  // The decomposition reads the lower triangle.
  const auto values = EigenvaluesOf<N>(information.transpose());
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
  // Scaled, so that the digits of weak directions do not drown in those of strong ones.
  const UnitDiagonal<N> unit = ScaleToUnitDiagonal<N>(information, kInformationTolerance);
  if (unit.indefinite) return false;
  const auto eigen = EigenOf<N>(unit.matrix.transpose());
  if (eigen.values(0) < -kInformationTolerance) return false;
  const double noise = N * std::numeric_limits<double>::epsilon() * eigen.values(N - 1);
  Eigen::Matrix<double, N, 1> roots;
  for (int k = 0; k < N; ++k) {
    const double value = eigen.values(k);
    roots(k) = value > noise ? std::sqrt(value) : 0;
  }
  *W = roots.asDiagonal() * eigen.vectors.transpose() * unit.scale.asDiagonal();
  return true;
}

template <int N>
Eigen::Matrix<double, N, N> ProjectInformation(const Eigen::Matrix<double, N, N>& information) {
  const auto eigen = EigenOf<N>(information.transpose());
  const double largest = eigen.values(N - 1);
  if (largest <= 0) return SquareMatrix<N>::Zero();
  const Eigen::Matrix<double, N, 1> values = eigen.values.cwiseMax(kProjectionFloor * largest);
  const SquareMatrix<N> m = eigen.vectors * values.asDiagonal() * eigen.vectors.transpose();
  return 0.5 * (m + m.transpose());
}

#define CERES_COSTS_INSTANTIATE(N)                                                             \
  template InformationKind ClassifyInformation<N>(const Eigen::Matrix<double, N, N>&, double); \
  template std::string InformationProblem<N>(const Eigen::Matrix<double, N, N>&);              \
  template EigenvalueRange InformationEigenvalues<N>(const Eigen::Matrix<double, N, N>&);      \
  template bool WhitenInformation<N>(const Eigen::Matrix<double, N, N>&,                       \
                                     Eigen::Matrix<double, N, N>*);                            \
  template Eigen::Matrix<double, N, N> ProjectInformation<N>(const Eigen::Matrix<double, N, N>&);
CERES_COSTS_INSTANTIATE(2)
CERES_COSTS_INSTANTIATE(3)
CERES_COSTS_INSTANTIATE(4)
CERES_COSTS_INSTANTIATE(6)
#undef CERES_COSTS_INSTANTIATE

}  // namespace ceres_costs
