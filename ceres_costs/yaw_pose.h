// Gravity-aligned poses for pose graphs: SE(2) x R, rotations about z with translations of space.
// Eigen only; works with ceres::Jet.
#pragma once

#include "ceres_costs/se2.h"

namespace ceres_costs {

// A rigid transform T_a_b of space that keeps z: p_a = Rz(yaw) p_b + t. The poses of a sensor whose
// roll and pitch are known, in frames turned upright.
//
// Storage, and the layout of a Ceres parameter block: x y z yaw; behind them the cosine and sine of
// the yaw, as in SE2T.
// Tangent order: translation first, then rotation.
// Perturbation: on the right. The retraction is Retract(d) = (t + R d_trans, yaw + d_rot), which
// agrees to first order with T * Exp(d).
// Not synchronized; distinct objects may be used from distinct threads.
template <typename S>
class YawPoseT {
 public:
  using Scalar = S;
  static constexpr int kDim = 3;          // of the space
  static constexpr int kDof = 4;          // of the tangent
  static constexpr int kRotationDof = 1;  // the last entries of the tangent
  static constexpr int kParams = 4;       // of data()
  using Vector = Eigen::Matrix<S, kDim, 1>;
  using RotationMatrix = Eigen::Matrix<S, kDim, kDim>;
  using Tangent = Eigen::Matrix<S, kDof, 1>;
  using Matrix = Eigen::Matrix<S, kDof, kDof>;

  YawPoseT() : data_{S(0), S(0), S(0), S(0)}, cos_(1), sin_(0) {}
  YawPoseT(const S& x, const S& y, const S& z, const S& yaw) : data_{x, y, z, yaw} {
    using std::cos;
    using std::sin;
    cos_ = cos(yaw);
    sin_ = sin(yaw);
  }
  explicit YawPoseT(const S* params) : YawPoseT(params[0], params[1], params[2], params[3]) {}

  const S* data() const { return data_; }
  Eigen::Map<const Vector> translation() const { return Eigen::Map<const Vector>(data_); }
  Eigen::Map<Vector> translation() { return Eigen::Map<Vector>(data_); }
  const S& angle() const { return data_[3]; }
  RotationMatrix matrix() const {
    RotationMatrix r = RotationMatrix::Identity();
    r(0, 0) = r(1, 1) = cos_;
    r(1, 0) = sin_;
    r(0, 1) = -sin_;
    return r;
  }

  YawPoseT operator*(const YawPoseT& o) const {
    return YawPoseT(*this * Vector(o.translation()), data_[3] + o.data_[3],
                    cos_ * o.cos_ - sin_ * o.sin_, sin_ * o.cos_ + cos_ * o.sin_);
  }
  Vector operator*(const Vector& p) const { return Turned(p, sin_) + translation(); }
  YawPoseT Inverse() const {
    return YawPoseT(-Turned(translation(), -sin_), -data_[3], cos_, -sin_);
  }
  // *this^-1 * o.
  YawPoseT Between(const YawPoseT& o) const {
    return YawPoseT(Turned(o.translation() - translation(), -sin_), o.data_[3] - data_[3],
                    cos_ * o.cos_ + sin_ * o.sin_, cos_ * o.sin_ - sin_ * o.cos_);
  }
  YawPoseT Normalized() const {
    return YawPoseT(data_[0], data_[1], data_[2], NormalizeAngle(data_[3]));
  }

  YawPoseT Retract(const Tangent& d) const {
    const Vector t = *this * Vector(d.template head<3>());
    return YawPoseT(t(0), t(1), t(2), NormalizeAngle(data_[3] + d(3)));
  }
  // The d for which this->Retract(d) == o.
  Tangent LocalCoordinates(const YawPoseT& o) const {
    const YawPoseT d = Between(o);
    return Tangent(d.data_[0], d.data_[1], d.data_[2], d.data_[3]);
  }

  // The group exponential of the twist (v, omega), and its inverse: those of SE(2), and z.
  static YawPoseT Exp(const Tangent& d) {
    const SE2T<S> plane = SE2T<S>::Exp(typename SE2T<S>::Tangent(d(0), d(1), d(3)));
    return YawPoseT(plane.data()[0], plane.data()[1], d(2), plane.angle());
  }
  Tangent Log() const {
    const typename SE2T<S>::Tangent d = SE2T<S>(data_[0], data_[1], data_[3]).Log();
    return Tangent(d(0), d(1), data_[2], d(2));
  }

  // *this * Exp(d), and the d for which x.Plus(d) == *this. Other than with Retract, the twists by
  // which a motion of the world moves two poses keep their relative pose, however far they go: in a
  // step of a solve, what moves as one stays rigid.
  YawPoseT Plus(const Tangent& d) const { return (*this * Exp(d)).Normalized(); }
  Tangent Minus(const YawPoseT& x) const { return x.Between(*this).Log(); }

  // T Exp(d) = Exp(Ad(T) d) T.
  Matrix Adjoint() const {
    Matrix m = Matrix::Identity();
    m.template topLeftCorner<3, 3>() = matrix();
    m(0, 3) = data_[1];
    m(1, 3) = -data_[0];
    return m;
  }
  // Ad(T^-1).
  Matrix InverseAdjoint() const {
    Matrix m = Matrix::Identity();
    m.template topLeftCorner<3, 3>() = matrix().transpose();
    const Vector t = Turned(translation(), -sin_);
    m(0, 3) = -t(1);
    m(1, 3) = t(0);
    return m;
  }

  template <typename N>
  YawPoseT<N> Cast() const {
    return YawPoseT<N>(N(data_[0]), N(data_[1]), N(data_[2]), N(data_[3]));
  }

  // What an archive needs to have the same bits again.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.data_, self.cos_, self.sin_);
  }

 private:
  YawPoseT(const Vector& t, const S& yaw, const S& cos_yaw, const S& sin_yaw)
      : data_{t(0), t(1), t(2), NormalizeAngle(yaw)}, cos_(cos_yaw), sin_(sin_yaw) {}

  // By the yaw, or against it where `sine` is that of the opposite angle.
  Vector Turned(const Vector& p, const S& sine) const {
    return Vector(cos_ * p(0) - sine * p(1), sine * p(0) + cos_ * p(1), p(2));
  }

  S data_[kParams];
  S cos_, sin_;
};

using YawPose = YawPoseT<double>;

// Right Jacobian of the group: Exp(xi + d) ~ Exp(xi) Exp(Jr(xi) d); this is its inverse.
YawPose::Matrix YawPoseRightJacobianInverse(const YawPose::Tangent& xi);

}  // namespace ceres_costs
