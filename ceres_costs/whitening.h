// Information matrices: what kind they are, and the factor that whitens an error. Eigen only. Every
// function reads the upper triangle alone, as files store it, and is instantiated for N = 2, 3,
// 4, 6.
#pragma once

#include <string>

#include "Eigen/Core"

namespace ceres_costs {

enum class InformationKind {
  kPositiveDefinite,
  kSemiDefinite,  // singular within the tolerance: some direction is not measured
  kIndefinite,    // an eigenvalue is negative: not the inverse of any covariance
  kNotFinite,     // an entry is nan or inf
};

// Of an eigenvalue, once the matrix is scaled to a unit diagonal (metres and radians share it).
inline constexpr double kInformationTolerance = 1e-9;

// By the smallest eigenvalue of D^-1/2 Omega D^-1/2, D the diagonal of Omega: positive definite if
// it exceeds the tolerance, indefinite if it lies below the negative of that. A negative diagonal
// entry, and a zero in a row that has others, are indefinite unless the row holds no more than what
// rounding leaves beside the largest entry. About as cheap as a Cholesky factorization where the
// answer is kPositiveDefinite.
template <int N>
InformationKind ClassifyInformation(const Eigen::Matrix<double, N, N>& information,
                                    double tolerance = kInformationTolerance);

// Why the matrix is no information, as "information is not positive semi-definite, smallest
// eigenvalue -1"; empty if it is: then WhitenInformation succeeds.
template <int N>
std::string InformationProblem(const Eigen::Matrix<double, N, N>& information);

// The extreme eigenvalues, for messages; nan where an entry is not finite.
struct EigenvalueRange {
  double min = 0;
  double max = 0;
};
template <int N>
EigenvalueRange InformationEigenvalues(const Eigen::Matrix<double, N, N>& information);

// W with W' W = Omega, so that |W e|^2 = e' Omega e. With Omega = L L' that is L', NOT L, whose
// square is another matrix unless Omega is diagonal. Upper triangular for a positive definite
// Omega; for a semi-definite one, W has rows of zeros instead of lost rank, and exact zeros in the
// columns of what is not measured. Negative eigenvalues within the tolerance count as zero. False,
// with W unchanged, if Omega is indefinite or not finite.
template <int N>
[[nodiscard]] bool WhitenInformation(const Eigen::Matrix<double, N, N>& information,
                                     Eigen::Matrix<double, N, N>* W);

// W e over any scalar. Jets multiply by doubles here; a matrix of Jets would cost twice as much.
template <typename S, int N>
void ApplyWhitening(const Eigen::Matrix<double, N, N>& W, const Eigen::Matrix<S, N, 1>& e,
                    S* residuals) {
  for (int r = 0; r < N; ++r) {
    residuals[r] = W(r, 0) * e(0);
    for (int c = 1; c < N; ++c) residuals[r] += W(r, c) * e(c);
  }
}

// The matrix with the same eigenvectors whose eigenvalues are raised to at least 1e-9 times the
// largest; zero if none is positive. Every entry must be finite.
template <int N>
Eigen::Matrix<double, N, N> ProjectInformation(const Eigen::Matrix<double, N, N>& information);

}  // namespace ceres_costs
