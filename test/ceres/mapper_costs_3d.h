// Costs and manifolds of mappers in 3D: what mapper_problems_3d.cc builds their problems from.
#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Cholesky"
#include "Eigen/Geometry"
#include "ceres/manifold.h"
#include "ceres/sized_cost_function.h"
#include "ceres_costs/se3.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo::mappers {

using ceres_costs::NormalizeAngle;
using ceres_costs::SE3;
using ceres_costs::SE3T;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

template <typename T>
using Quaternion = Eigen::Quaternion<T>;

// Where a mapper keeps a pose: the blocks and the order of its numbers.
enum class Layout { kTQ, kTQw, kQwT, k7TQ, k7QT };  // w first where it says w

template <Layout kLayout, typename T>
SE3T<T> ReadPose(const T* first, const T* second) {
  const T* t = first;
  const T* q = second;
  if (kLayout == Layout::kQwT || kLayout == Layout::k7QT) std::swap(t, q);
  const bool w_first = kLayout == Layout::kTQw || kLayout == Layout::kQwT;
  return SE3T<T>(
      Eigen::Matrix<T, 3, 1>(t[0], t[1], t[2]),
      w_first ? Quaternion<T>(q[0], q[1], q[2], q[3]) : Quaternion<T>(q[3], q[0], q[1], q[2]));
}

inline void WritePose(Layout layout, const SE3& pose, double* values) {
  const double* p = pose.data();
  switch (layout) {
    case Layout::kTQ:
    case Layout::k7TQ:
      std::copy_n(p, 7, values);
      break;
    case Layout::kTQw:
      for (const int k : {0, 1, 2, 6, 3, 4, 5}) *values++ = p[k];
      break;
    case Layout::kQwT:
      for (const int k : {6, 3, 4, 5, 0, 1, 2}) *values++ = p[k];
      break;
    case Layout::k7QT:
      for (const int k : {3, 4, 5, 6, 0, 1, 2}) *values++ = p[k];
      break;
  }
}

// S [translation of D; 2 vec of its quaternion] with D = Z^-1 X_i^-1 X_j; the extrinsics move with
// the body.
template <Layout kLayout>
struct RelativeError {
  template <typename T>
  bool Evaluate(const SE3T<T>& X_i, const SE3T<T>& X_j, T* residuals) const {
    const SE3T<T> D = z.Cast<T>().Between(X_i.Between(X_j));
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    Quaternion<T> q = D.rotation();
    if (q.w() < T(0)) q.coeffs() = -q.coeffs();
    r.template head<3>() = D.translation();
    r.template tail<3>() = T(2) * q.vec();
    r = S.template cast<T>() * r;
    return true;
  }
  template <typename T>
  bool operator()(const T* a, const T* b, T* r) const {
    constexpr int kSecond = kLayout == Layout::k7QT ? 4 : 3;
    return Evaluate(ReadPose<kLayout>(a, a + kSecond), ReadPose<kLayout>(b, b + kSecond), r);
  }
  template <typename T>
  bool operator()(const T* a1, const T* a2, const T* b1, const T* b2, T* r) const {
    if constexpr (kLayout == Layout::k7QT) {  // pose, pose, extrinsic, extrinsic
      const SE3T<T> E_1 = ReadPose<kLayout>(b1, b1 + 4), E_2 = ReadPose<kLayout>(b2, b2 + 4);
      return Evaluate(ReadPose<kLayout>(a1, a1 + 4) * E_1, ReadPose<kLayout>(a2, a2 + 4) * E_2, r);
    } else {
      return Evaluate(ReadPose<kLayout>(a1, a2), ReadPose<kLayout>(b1, b2), r);
    }
  }

  SE3 z;
  Matrix6d S;
};

// Of a position alone, and of a whole pose as a relative one from a frame that it ignores.
struct PositionError {
  template <typename T>
  bool operator()(const T* t, T* r) const {
    for (int k = 0; k < 3; ++k) r[k] = (t[k] - z(k)) / sigma;
    return true;
  }
  Eigen::Vector3d z;
  double sigma;
};
struct AbsoluteError {
  template <typename T>
  bool operator()(const T* x, T* r) const {
    return RelativeError<Layout::k7TQ>{z, S}.Evaluate(SE3T<T>(), ReadPose<Layout::k7TQ>(x, x + 3),
                                                      r);
  }
  SE3 z;
  Matrix6d S;
};

// q Exp(d) with w first.
struct RightFullAngle {
  template <typename T>
  bool Plus(const T* x, const T* d, T* y) const {
    const Quaternion<T> q = Quaternion<T>(x[0], x[1], x[2], x[3]) *
                            ceres_costs::So3Exp(Eigen::Matrix<T, 3, 1>(d[0], d[1], d[2]));
    y[0] = q.w(), y[1] = q.x(), y[2] = q.y(), y[3] = q.z();
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* d) const {
    const Quaternion<T> q =
        Quaternion<T>(x[0], x[1], x[2], x[3]).conjugate() * Quaternion<T>(y[0], y[1], y[2], y[3]);
    const Eigen::Matrix<T, 3, 1> log = ceres_costs::So3Log(q);
    for (int k = 0; k < 3; ++k) d[k] = log(k);
    return true;
  }
};

// Roll and pitch alone, w first: Cartographer's rotation of the first submap.
struct ConstantYaw {
  template <typename T>
  bool Plus(const T* x, const T* d, T* y) const {
    const Quaternion<T> q = ceres_costs::So3Exp(Eigen::Matrix<T, 3, 1>(d[0], d[1], T(0))) *
                            Quaternion<T>(x[0], x[1], x[2], x[3]);
    y[0] = q.w(), y[1] = q.x(), y[2] = q.y(), y[3] = q.z();
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* d) const {
    const Quaternion<T> q =
        Quaternion<T>(y[0], y[1], y[2], y[3]) * Quaternion<T>(x[0], x[1], x[2], x[3]).conjugate();
    const Eigen::Matrix<T, 3, 1> log = ceres_costs::So3Log(q);
    d[0] = log(0), d[1] = log(1);
    return true;
  }
};

// Exp(d) X, whose PlusJacobian leaves the Jacobians of LiftedCost as they are.
class LeftLiftedManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* d, double* y) const override {
    const SE3 X = SE3::Exp(Eigen::Map<const SE3::Tangent>(d)) * SE3(x);
    std::copy_n(X.Normalized().data(), 7, y);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> J(jacobian);
    J.setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* d) const override {
    Eigen::Map<SE3::Tangent> out(d);
    out = (SE3(y) * SE3(x).Inverse()).Log();
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> J(jacobian);
    J.setIdentity();
    return true;
  }
};

// S Log(Z^-1 X_i^-1 X_j), Jacobians by a perturbation on the left in the first six columns.
class LiftedCost final : public ceres::SizedCostFunction<6, 7, 7> {
 public:
  LiftedCost(const SE3& z, const Matrix6d& S) : z_(z), S_(S) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const SE3 X_j(x[1]);
    const SE3::Tangent e = z_.Between(SE3(x[0]).Between(X_j)).Log();
    Eigen::Map<SE3::Tangent> r(residuals);
    r = S_ * e;
    if (jacobians == nullptr) return true;
    const Matrix6d J = S_ * ceres_costs::Se3RightJacobianInverse(e) * X_j.InverseAdjoint();
    for (int b = 0; b < 2; ++b) {
      if (jacobians[b] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> out(jacobians[b]);
      out.leftCols<6>() = b == 0 ? Matrix6d(-J) : J;
      out.col(6).setZero();
    }
    return true;
  }

 private:
  SE3 z_;
  Matrix6d S_;
};

// Yaw about z, and what of the orientation is known: R = Rz(yaw) known.
inline double YawOf(const SE3& pose) {
  const Eigen::Matrix3d R = pose.matrix();
  return std::atan2(R(1, 0), R(0, 0));
}

template <typename T>
Eigen::Matrix<T, 3, 1> RotateBack(const T& yaw, const Eigen::Matrix<T, 3, 1>& v) {
  using std::cos;
  using std::sin;
  const T c = cos(yaw), s = sin(yaw);
  return {c * v(0) + s * v(1), -s * v(0) + c * v(1), v(2)};
}

// [K_i' Rz(yaw_i)' (t_j - t_i) - z; yaw_j - yaw_i - yaw_z], roll and pitch K_i known.
template <bool kDegrees>
struct YawError {
  template <typename T>
  bool operator()(const T* yaw_i, const T* t_i, const T* yaw_j, const T* t_j, T* r) const {
    const T unit(kDegrees ? M_PI / 180 : 1);
    const Eigen::Matrix<T, 3, 1> d(t_j[0] - t_i[0], t_j[1] - t_i[1], t_j[2] - t_i[2]);
    const Eigen::Matrix<T, 3, 1> local =
        K.transpose().template cast<T>() * RotateBack(T(*yaw_i * unit), d);
    for (int k = 0; k < 3; ++k) r[k] = (local(k) - z(k)) / sigma_t;
    r[3] = NormalizeAngle(T((*yaw_j - *yaw_i) * unit - yaw)) / sigma_r;
    return true;
  }
  template <typename T>
  bool operator()(const T* a, const T* b, T* r) const {
    return (*this)(a + 3, a, b + 3, b, r);
  }
  Eigen::Matrix3d K;
  Eigen::Vector3d z;
  double yaw, sigma_t, sigma_r;
};

template <bool kDegrees>
struct AngleFunctor {
  template <typename T>
  bool Plus(const T* x, const T* delta, T* y) const {
    const double unit = kDegrees ? 180 / M_PI : 1;
    *y = NormalizeAngle(T((*x + *delta) / unit)) * unit;
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* d) const {
    *d = *y - *x;
    return true;
  }
};

inline Matrix6d Whitening(const GraphEdge<SE3>& edge) {
  Matrix6d S = edge.information.llt().matrixU();
  S.rightCols<3>() /= 2;  // the costs have twice the quaternion's vector
  return S;
}

}  // namespace hpgo::mappers
