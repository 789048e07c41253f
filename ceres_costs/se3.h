// SE(3) for pose graphs. Eigen only; works with ceres::Jet.
#pragma once

#include <type_traits>

#include "ceres_costs/so3.h"

namespace ceres_costs {

// A rigid transform T_a_b: p_a = R p_b + t.
//
// Storage, and the layout of a Ceres parameter block: x y z qx qy qz qw (as in g2o files).
// Tangent order: translation first, then rotation.
// Perturbation: on the right. The retraction is Retract(d) = (R Exp(d_rot), t + R d_trans), which
// agrees to first order with T * Exp(d); Exp and Log are those of the group (the twist).
// Not synchronized; distinct objects may be used from distinct threads.
template <typename S>
class SE3T {
 public:
  using Scalar = S;
  static constexpr int kDim = 3;          // of the space
  static constexpr int kDof = 6;          // of the tangent
  static constexpr int kRotationDof = 3;  // the last entries of the tangent
  static constexpr int kParams = 7;       // of the storage
  using Vector = Eigen::Matrix<S, kDim, 1>;
  using RotationMatrix = Eigen::Matrix<S, kDim, kDim>;
  using Quaternion = Eigen::Quaternion<S>;
  using Tangent = Eigen::Matrix<S, kDof, 1>;
  using Matrix = Eigen::Matrix<S, kDof, kDof>;

  SE3T() : data_{S(0), S(0), S(0), S(0), S(0), S(0), S(1)} {}
  template <typename DerivedT, typename DerivedQ>
  SE3T(const Eigen::MatrixBase<DerivedT>& t, const Eigen::QuaternionBase<DerivedQ>& q)
      : data_{t(0), t(1), t(2), q.x(), q.y(), q.z(), q.w()} {}
  explicit SE3T(const S* params) {
    for (int i = 0; i < kParams; ++i) data_[i] = params[i];
  }

  const S* data() const { return data_; }
  S* data() { return data_; }
  Eigen::Map<const Vector> translation() const { return Eigen::Map<const Vector>(data_); }
  Eigen::Map<Vector> translation() { return Eigen::Map<Vector>(data_); }
  // Const by value: Eigen 3.4 does not compile the non-const accessors of a const Map.
  const Eigen::Map<const Quaternion> rotation() const {
    return Eigen::Map<const Quaternion>(data_ + 3);
  }
  Eigen::Map<Quaternion> rotation() { return Eigen::Map<Quaternion>(data_ + 3); }
  RotationMatrix matrix() const { return rotation().toRotationMatrix(); }

  SE3T operator*(const SE3T& o) const {
    const Eigen::Map<const Quaternion> q = rotation();
    return SE3T(translation() + q * Vector(o.translation()), q * o.rotation());
  }
  Vector operator*(const Vector& p) const { return rotation() * p + translation(); }
  SE3T Inverse() const {
    const Quaternion qi = rotation().conjugate();
    return SE3T(-(qi * Vector(translation())), qi);
  }
  // *this^-1 * o.
  SE3T Between(const SE3T& o) const {
    const Quaternion qi = rotation().conjugate();
    return SE3T(qi * Vector(o.translation() - translation()), qi * o.rotation());
  }
  SE3T Normalized() const {
    if constexpr (std::is_floating_point_v<S>) {
      const S largest_square(1e300);  // beyond, the square of the norm may be infinite
      if (rotation().squaredNorm() > largest_square) {
        const S scale = rotation().coeffs().cwiseAbs().maxCoeff();
        return SE3T(translation(), Quaternion(rotation().coeffs() / scale).normalized());
      }
    }
    return SE3T(translation(), rotation().normalized());
  }

  SE3T Retract(const Tangent& d) const {
    const Eigen::Map<const Quaternion> q = rotation();
    return SE3T(translation() + q * Vector(d.template head<3>()),
                (q * So3Exp(d.template tail<3>())).normalized());
  }
  // The d for which this->Retract(d) == o, up to the sign of the quaternion.
  Tangent LocalCoordinates(const SE3T& o) const {
    const SE3T d = Between(o);
    Tangent r;
    r << d.translation(), So3Log(d.rotation());
    return r;
  }

  // The group exponential of the twist (v, omega), and its inverse (paper, eq. 3).
  static SE3T Exp(const Tangent& d) {
    // The left Jacobian is the right one of the opposite rotation vector.
    const Vector omega = d.template tail<3>();
    return SE3T(So3RightJacobian(-omega) * d.template head<3>(), So3Exp(omega));
  }
  Tangent Log() const {
    const Vector omega = So3Log(rotation());
    Tangent r;
    r << So3RightJacobianInverse(-omega) * translation(), omega;
    return r;
  }

  // *this * Exp(d), and the d for which x.Plus(d) == *this. Other than with Retract, the twists by
  // which a motion of the world moves two poses keep their relative pose, however far they go: in a
  // step of a solve, what moves as one stays rigid.
  SE3T Plus(const Tangent& d) const { return (*this * Exp(d)).Normalized(); }
  Tangent Minus(const SE3T& x) const { return x.Between(*this).Log(); }

  // Ad(T) = [R, [t]x R; 0, R]: T Exp(d) = Exp(Ad(T) d) T.
  Matrix Adjoint() const {
    const RotationMatrix r = matrix();
    Matrix m;
    m.template topLeftCorner<3, 3>() = r;
    m.template topRightCorner<3, 3>() = Skew(translation()) * r;
    m.template bottomLeftCorner<3, 3>().setZero();
    m.template bottomRightCorner<3, 3>() = r;
    return m;
  }
  // Ad(T^-1) = [R', -R' [t]x; 0, R'].
  Matrix InverseAdjoint() const {
    const RotationMatrix r = matrix().transpose();
    Matrix m;
    m.template topLeftCorner<3, 3>() = r;
    m.template topRightCorner<3, 3>() = -r * Skew(translation());
    m.template bottomLeftCorner<3, 3>().setZero();
    m.template bottomRightCorner<3, 3>() = r;
    return m;
  }

  template <typename N>
  SE3T<N> Cast() const {
    SE3T<N> r;
    for (int i = 0; i < kParams; ++i) r.data()[i] = N(data_[i]);
    return r;
  }

  // For archives.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.data_);
  }

 private:
  S data_[kParams];
};

using SE3 = SE3T<double>;

// Right Jacobian of the group: Exp(xi + d) ~ Exp(xi) Exp(Jr(xi) d); this is its inverse.
SE3::Matrix Se3RightJacobianInverse(const SE3::Tangent& xi);

}  // namespace ceres_costs
