// Poses as Ceres manifolds, and the Jacobians between a pose's storage and its tangent space.
#pragma once

#include <memory>

#include "ceres/manifold.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace ceres_costs {

// By what a cost function writes its Jacobians. A cost and the manifold of its blocks must agree.
enum class JacobianKind {
  kAmbient,  // by the stored parameters: what Ceres and foreign costs expect. With PoseManifold
  kLocal,    // by the tangent, in the first kDof columns, zeros after. With LocalPoseManifold
};

// What the two manifolds share, the exponential of G: Plus(x, d) = x.Plus(d) and
// Minus(y, x) = y.Minus(x). A block is a pose in the storage order of G; a quaternion
// must be of unit norm. Stateless: one object serves any number of blocks, problems and threads.
template <typename G>
class ExponentialManifold : public ceres::Manifold {
 public:
  int AmbientSize() const final { return G::kParams; }
  int TangentSize() const final { return G::kDof; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const final;
  bool Minus(const double* y, const double* x, double* y_minus_x) const final;
};

// With the true Jacobians, for any cost by the stored parameters.
template <typename G>
class PoseManifold final : public ExponentialManifold<G> {
 public:
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// With PlusJacobian = [I; 0], for costs of JacobianKind::kLocal alone: their Jacobian times [I; 0]
// is the local one, which saves them the way through the ambient space.
template <typename G>
class LocalPoseManifold final : public ExponentialManifold<G> {
 public:
  bool PlusJacobian(const double* x, double* jacobian) const override;
  bool MinusJacobian(const double* x, double* jacobian) const override;
};

// The one that goes with costs of `kind`.
template <typename G>
std::unique_ptr<ceres::Manifold> MakePoseManifold(JacobianKind kind);

// d Plus(d) / d d and d Retract(d) / d d at 0, kParams x kDof:
// J_local = J_ambient * RetractionJacobian(x).
inline Eigen::Matrix<double, 3, 3> RetractionJacobian(const SE2& x) {
  Eigen::Matrix<double, 3, 3> P = Eigen::Matrix<double, 3, 3>::Identity();
  P.topLeftCorner<2, 2>() = x.matrix();
  return P;
}
inline Eigen::Matrix<double, 7, 6> RetractionJacobian(const SE3& x) {
  Eigen::Matrix<double, 7, 6> P = Eigen::Matrix<double, 7, 6>::Zero();
  P.topLeftCorner<3, 3>() = x.matrix();
  P.block<3, 3>(3, 3) = 0.5 * Skew(x.rotation().vec());
  P.block<3, 3>(3, 3).diagonal().array() += 0.5 * x.rotation().w();
  P.bottomRightCorner<1, 3>() = -0.5 * x.rotation().vec().transpose();
  return P;
}
inline Eigen::Matrix<double, 4, 4> RetractionJacobian(const YawPose& x) {
  Eigen::Matrix<double, 4, 4> P = Eigen::Matrix<double, 4, 4>::Identity();
  P.topLeftCorner<3, 3>() = x.matrix();
  return P;
}

// d x.LocalCoordinates(y) / d y at y = x, kDof x kParams, the left inverse of RetractionJacobian: a
// local Jacobian times it is an ambient one.
inline Eigen::Matrix<double, 3, 3> LocalCoordinatesJacobian(const SE2& x) {
  return RetractionJacobian(x).transpose();
}
inline Eigen::Matrix<double, 4, 4> LocalCoordinatesJacobian(const YawPose& x) {
  return RetractionJacobian(x).transpose();
}
inline Eigen::Matrix<double, 6, 7> LocalCoordinatesJacobian(const SE3& x) {
  Eigen::Matrix<double, 6, 7> M = RetractionJacobian(x).transpose();
  M.bottomRightCorner<3, 4>() *= 4;  // the columns of a quaternion's retraction have length 1/2
  return M;
}

// Writes the Jacobian J of kDof residuals under a right perturbation of the pose x into a row-major
// kDof x kParams array, as Ceres passes to CostFunction::Evaluate.
template <typename G>
void WriteJacobian(JacobianKind kind, const G& x, const typename G::Matrix& J, double* jacobian) {
  // Ceres' arrays are row-major.
  using Array = Eigen::Matrix<double, G::kDof, G::kParams, Eigen::RowMajor>;
  Eigen::Map<Array> out(jacobian);
  if (kind == JacobianKind::kLocal) {
    out.template leftCols<G::kDof>() = J;
    out.template rightCols<G::kParams - G::kDof>().setZero();
  } else {
    out.noalias() = J * LocalCoordinatesJacobian(x);
  }
}

}  // namespace ceres_costs
