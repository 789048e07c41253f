#include "ceres_costs/stretched_edge.h"

#include <algorithm>

#include "Eigen/Cholesky"
#include "ceres_costs/symmetric_eigen.h"

namespace ceres_costs {
namespace {

template <typename G>
using Lever = Eigen::Matrix<double, G::kDim, G::kRotationDof>;

// omega x p by omega.
Lever<SE3> LeverOf(const SE3&, const SE3::Vector& p) { return -Skew(p); }
Lever<SE2> LeverOf(const SE2&, const SE2::Vector& p) { return {-p.y(), p.x()}; }
Lever<YawPose> LeverOf(const YawPose&, const YawPose::Vector& p) { return {-p.y(), p.x(), 0}; }

// The largest k for which Omega without k in all directions of translation is semi-definite.
template <typename G>
double AlikeInAllDirections(const typename G::Matrix& omega) {
  constexpr int kDim = G::kDim, kRotationDof = G::kRotationDof;
  Eigen::Matrix<double, kDim, kDim> own = omega.template topLeftCorner<kDim, kDim>();
  const Eigen::Matrix<double, kRotationDof, kDim> cross =
      omega.template bottomLeftCorner<kRotationDof, kDim>();
  if (!cross.isZero(0)) {
    const Eigen::LLT<Eigen::Matrix<double, kRotationDof, kRotationDof>> rotation(
        omega.template bottomRightCorner<kRotationDof, kRotationDof>());
    if (rotation.info() != Eigen::Success) return 0;
    own -= cross.transpose() * rotation.solve(cross);
  }
  return std::max(0., EigenvaluesOf(own)(0));
}

// Of the symmetric part.
template <int N>
Eigen::Matrix<double, N, N> WithoutNegative(const Eigen::Matrix<double, N, N>& matrix) {
  const SymmetricEigen<N> eigen =
      EigenOf(Eigen::Matrix<double, N, N>((matrix + matrix.transpose()) / 2));
  return eigen.vectors * eigen.values.cwiseMax(0).asDiagonal() * eigen.vectors.transpose();
}

}  // namespace

template <typename G>
void StretchedModel(const FactorTerm<G>& factor, const G& T_i_j, typename G::Matrix* ii,
                    typename G::Matrix* ji) {
  constexpr int kDim = G::kDim, kRotationDof = G::kRotationDof;
  double k = AlikeInAllDirections<G>(factor.term->information.Dense());
  if (factor.loss != nullptr) {
    FactorTerm<G> squared = factor;
    squared.loss = nullptr;
    double rho[3];
    factor.loss->Evaluate(FactorCost(squared, false, T_i_j), rho);
    k *= std::max(0., rho[1]);
  }
  // Gauss-Newton has k |v - omega x t|^2 with v = R_i_j v_j - v_i, the second derivative is
  // k |v - omega x z|^2 + k (omega x (t - z))' (omega x z).
  const typename G::Vector t = T_i_j.translation(), z = factor.term->measurement.translation();
  const Lever<G> far = LeverOf(T_i_j, t), near = LeverOf(T_i_j, z), off = far - near;
  using RotationMatrix = Eigen::Matrix<double, kRotationDof, kRotationDof>;
  const RotationMatrix turned = off.transpose() * near;
  ii->setZero();
  ii->template topRightCorner<kDim, kRotationDof>() = -k * off;
  ii->template bottomLeftCorner<kRotationDof, kDim>() = -k * off.transpose();
  ii->template bottomRightCorner<kRotationDof, kRotationDof>() =
      k * (near.transpose() * near - far.transpose() * far + WithoutNegative(turned));
  ji->setZero();
  ji->template topRightCorner<kDim, kRotationDof>() = k * T_i_j.matrix().transpose() * off;
}

template void StretchedModel(const FactorTerm<SE2>&, const SE2&, SE2::Matrix*, SE2::Matrix*);
template void StretchedModel(const FactorTerm<SE3>&, const SE3&, SE3::Matrix*, SE3::Matrix*);
template void StretchedModel(const FactorTerm<YawPose>&, const YawPose&, YawPose::Matrix*,
                             YawPose::Matrix*);

}  // namespace ceres_costs
