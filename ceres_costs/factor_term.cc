#include "ceres_costs/factor_term.h"

#include <cmath>
#include <limits>
#include <vector>

#include "ceres_costs/manifolds.h"

namespace ceres_costs {
namespace {

template <typename G>
using Tangent = typename G::Tangent;
template <typename G>
using Matrix = typename G::Matrix;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// e' Omega from the upper triangle, without unpacking it.
template <int N>
Eigen::Matrix<double, N, 1> PackedTimes(const PackedSymmetric<N>& omega,
                                        const Eigen::Matrix<double, N, 1>& e) {
  Eigen::Matrix<double, N, 1> r = Eigen::Matrix<double, N, 1>::Zero();
  const double* v = omega.data();
  for (int i = 0; i < N; ++i) {
    r(i) += *v++ * e(i);
    for (int j = i + 1; j < N; ++j, ++v) {
      r(i) += *v * e(j);
      r(j) += *v * e(i);
    }
  }
  return r;
}

// Replaces a squared error, at least zero, by rho of it; returns the factor on A and b. The second
// derivative is used only where it is positive, as in Ceres' corrector; then `curvature` multiplies
// b b'.
double ApplyLoss(const ceres::LossFunction* loss, double* cost, double* curvature) {
  *curvature = 0;
  if (*cost < 0) *cost = 0;  // the rounding of a semi-definite form
  if (loss == nullptr) return 1;
  double rho[3];
  loss->Evaluate(*cost, rho);
  *cost = rho[0];
  if (rho[2] > 0) *curvature = 2 * rho[2];
  return rho[1];
}

// Residuals of a custom cost and their Jacobian by a right perturbation of X_j.
template <typename G>
bool EvaluateCustom(const ceres::CostFunction& cost, bool unary, const G& T_i_j,
                    Eigen::VectorXd* residuals, RowMajor* J) {
  const int m = cost.num_residuals();
  residuals->resize(m);
  const G origin;
  const double* parameters[2] = {origin.data(), T_i_j.data()};
  RowMajor ambient(m, G::kParams);
  double* jacobians[2] = {nullptr, ambient.data()};
  const bool ok = cost.Evaluate(unary ? parameters + 1 : parameters, residuals->data(),
                                J == nullptr ? nullptr : (unary ? jacobians + 1 : jacobians));
  if (!ok || !residuals->allFinite()) return false;
  if (J != nullptr) {
    *J = ambient * RetractionJacobian(T_i_j);
    return J->allFinite();
  }
  return true;
}

template <typename G>
Tangent<G> TermError(const FactorTerm<G>& factor, const G& T, Matrix<G>* J) {
  if (factor.offset == nullptr) {
    return RelativePoseError(factor.convention, factor.term->measurement, T, J);
  }
  const Tangent<G> e =
      RelativePoseError(factor.convention, factor.term->measurement, T * *factor.offset, J);
  if (J != nullptr) *J = *J * factor.offset->Inverse().Adjoint();
  return e;
}

// J' Omega J for the block-diagonal Jacobian of the g2o and split-logarithm errors in 3D.
void Accumulate(const FactorTerm<SE3>& factor, const Matrix<SE3>& J, const Tangent<SE3>& e,
                QuadraticModel<SE3>* model) {
  const Matrix<SE3> omega = factor.term->information.Dense();
  const Tangent<SE3> we = omega * e;
  model->cost = e.dot(we);
  if (factor.convention == ErrorConvention::kTwist || factor.offset != nullptr) {
    model->A = J.transpose() * omega * J;
    model->b = J.transpose() * we;
    return;
  }
  const Eigen::Matrix3d R = J.topLeftCorner<3, 3>(), Q = J.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d RtO = R.transpose() * omega.topLeftCorner<3, 3>();
  const Eigen::Matrix3d RtX = R.transpose() * omega.topRightCorner<3, 3>();
  const Eigen::Matrix3d QtO = Q.transpose() * omega.bottomRightCorner<3, 3>();
  model->A.topLeftCorner<3, 3>().noalias() = RtO * R;
  model->A.topRightCorner<3, 3>().noalias() = RtX * Q;
  model->A.bottomLeftCorner<3, 3>() = model->A.topRightCorner<3, 3>().transpose();
  model->A.bottomRightCorner<3, 3>().noalias() = QtO * Q;
  model->b.head<3>().noalias() = R.transpose() * we.head<3>();
  model->b.tail<3>().noalias() = Q.transpose() * we.tail<3>();
}

template <typename G>
void Accumulate(const FactorTerm<G>& factor, const Matrix<G>& J, const Tangent<G>& e,
                QuadraticModel<G>* model) {
  const Matrix<G> omega = factor.term->information.Dense();
  const Tangent<G> we = omega * e;
  model->cost = e.dot(we);
  model->A.noalias() = J.transpose() * omega * J;
  model->b.noalias() = J.transpose() * we;
}

}  // namespace

template <typename G>
double FactorCost(const FactorTerm<G>& factor, bool unary, const G& T_i_j) {
  double cost;
  if (factor.custom != nullptr) {
    Eigen::VectorXd r;
    if (!EvaluateCustom(*factor.custom, unary, T_i_j, &r, nullptr)) {
      return std::numeric_limits<double>::quiet_NaN();
    }
    cost = r.squaredNorm();
  } else {
    const Tangent<G> e = TermError<G>(factor, T_i_j, nullptr);
    cost = e.dot(PackedTimes(factor.term->information, e));
  }
  double curvature;
  ApplyLoss(factor.loss, &cost, &curvature);
  return cost;
}

template <typename G>
bool LinearizeFactor(const FactorTerm<G>& factor, bool unary, const G& T_i_j,
                     QuadraticModel<G>* model) {
  if (factor.custom != nullptr) {
    Eigen::VectorXd r;
    RowMajor J;
    if (!EvaluateCustom(*factor.custom, unary, T_i_j, &r, &J)) return false;
    model->A = J.transpose() * J;
    model->b = J.transpose() * r;
    model->cost = r.squaredNorm();
  } else {
    Matrix<G> J;
    const Tangent<G> e = TermError(factor, T_i_j, &J);
    Accumulate(factor, J, e, model);
  }
  double curvature;
  const double weight = ApplyLoss(factor.loss, &model->cost, &curvature);
  if (factor.loss == nullptr) return true;
  model->A *= weight;
  if (curvature > 0) model->A += curvature * model->b * model->b.transpose();
  model->b *= weight;
  return true;
}

template <typename G>
double FactorChange(const FactorTerm<G>& factor, bool unary, const G& T0, const G& T1) {
  double change, cost;
  if (factor.custom != nullptr) {
    Eigen::VectorXd r0, r1;
    if (!EvaluateCustom(*factor.custom, unary, T0, &r0, nullptr) ||
        !EvaluateCustom(*factor.custom, unary, T1, &r1, nullptr)) {
      return 0;
    }
    change = (r1 - r0).squaredNorm();
    cost = r1.squaredNorm();
  } else {
    const Tangent<G> e1 = TermError<G>(factor, T1, nullptr);
    const Tangent<G> d = e1 - TermError<G>(factor, T0, nullptr);
    change = d.dot(PackedTimes(factor.term->information, d));
    cost = factor.loss == nullptr ? 0 : e1.dot(PackedTimes(factor.term->information, e1));
  }
  double curvature;
  return std::sqrt(std::max(0., change * ApplyLoss(factor.loss, &cost, &curvature)));
}

template <typename G>
void TransportModel(const G& T, const QuadraticModel<G>& in, QuadraticModel<G>* out,
                    Matrix<G>* AM) {
  const Matrix<G> M = T.Adjoint();
  const Matrix<G> right = in.A * M;
  const Matrix<G> A = M.transpose() * right;
  const Tangent<G> b = M.transpose() * in.b;
  out->A = A;
  out->b = b;
  out->cost = in.cost;
  if (AM != nullptr) *AM = right;
}

template <>
void TransportModel(const SE3& T, const QuadraticModel<SE3>& in, QuadraticModel<SE3>* out,
                    Matrix<SE3>* AM) {
  const Eigen::Matrix3d R = T.matrix();
  const Eigen::Matrix3d S = Skew(T.translation()) * R;  // Ad = [R S; 0 R]
  const Eigen::Matrix3d A11 = in.A.topLeftCorner<3, 3>(), A12 = in.A.topRightCorner<3, 3>();
  const Eigen::Matrix3d A22 = in.A.bottomRightCorner<3, 3>();
  const Eigen::Matrix3d AR = A11 * R;                        // top left of A Ad
  const Eigen::Matrix3d AX = A11 * S + A12 * R;              // top right
  const Eigen::Matrix3d AY = A12.transpose() * S + A22 * R;  // bottom right
  out->A.topLeftCorner<3, 3>().noalias() = R.transpose() * AR;
  out->A.topRightCorner<3, 3>().noalias() = R.transpose() * AX;
  out->A.bottomLeftCorner<3, 3>() = out->A.topRightCorner<3, 3>().transpose();
  out->A.bottomRightCorner<3, 3>().noalias() = S.transpose() * AX + R.transpose() * AY;
  const Eigen::Vector3d bt = in.b.head<3>(), br = in.b.tail<3>();
  out->b.head<3>().noalias() = R.transpose() * bt;
  out->b.tail<3>().noalias() = S.transpose() * bt + R.transpose() * br;
  out->cost = in.cost;
  if (AM == nullptr) return;
  AM->topLeftCorner<3, 3>() = AR;
  AM->topRightCorner<3, 3>() = AX;
  AM->bottomLeftCorner<3, 3>().noalias() = A12.transpose() * R;
  AM->bottomRightCorner<3, 3>() = AY;
}

template double FactorCost(const FactorTerm<SE2>&, bool, const SE2&);
template double FactorCost(const FactorTerm<SE3>&, bool, const SE3&);
template double FactorCost(const FactorTerm<YawPose>&, bool, const YawPose&);
template bool LinearizeFactor(const FactorTerm<SE2>&, bool, const SE2&, QuadraticModel<SE2>*);
template bool LinearizeFactor(const FactorTerm<SE3>&, bool, const SE3&, QuadraticModel<SE3>*);
template bool LinearizeFactor(const FactorTerm<YawPose>&, bool, const YawPose&,
                              QuadraticModel<YawPose>*);
template double FactorChange(const FactorTerm<SE2>&, bool, const SE2&, const SE2&);
template double FactorChange(const FactorTerm<SE3>&, bool, const SE3&, const SE3&);
template double FactorChange(const FactorTerm<YawPose>&, bool, const YawPose&, const YawPose&);
template void TransportModel(const SE2&, const QuadraticModel<SE2>&, QuadraticModel<SE2>*,
                             SE2::Matrix*);
template void TransportModel(const YawPose&, const QuadraticModel<YawPose>&,
                             QuadraticModel<YawPose>*, YawPose::Matrix*);

}  // namespace ceres_costs
