// SE(2) for pose graphs. Eigen only; works with ceres::Jet.
#pragma once

#include <cmath>
#include <type_traits>

#include "Eigen/Core"

namespace ceres_costs {

// The angle in [-pi, pi]; a value already inside is returned unchanged, bit for bit.
template <typename S>
S NormalizeAngle(const S& angle) {
  using std::floor;
  constexpr double kPi = 3.14159265358979323846;
  if (angle >= S(-kPi) && angle <= S(kPi)) return angle;
  // Rounding would leave very large ones outside.
  if constexpr (std::is_floating_point_v<S>) return std::remainder(angle, S(2 * kPi));
  return angle - S(2 * kPi) * floor((angle + S(kPi)) / S(2 * kPi));
}

// A rigid transform of the plane, T_a_b: p_a = R(theta) p_b + t.
//
// Storage, and the layout of a Ceres parameter block: x y theta (as in g2o files); behind them the
// cosine and sine of theta, which products get without trigonometry and Normalized() computes anew.
// Tangent order: translation first, then rotation.
// Perturbation: on the right. The retraction is Retract(d) = (t + R d_trans, theta + d_rot), which
// agrees to first order with T * Exp(d).
// Not synchronized; distinct objects may be used from distinct threads.
template <typename S>
class SE2T {
 public:
  using Scalar = S;
  static constexpr int kDim = 2;          // of the space
  static constexpr int kDof = 3;          // of the tangent
  static constexpr int kRotationDof = 1;  // the last entries of the tangent
  static constexpr int kParams = 3;       // of data()
  using Vector = Eigen::Matrix<S, kDim, 1>;
  using RotationMatrix = Eigen::Matrix<S, kDim, kDim>;
  using Tangent = Eigen::Matrix<S, kDof, 1>;
  using Matrix = Eigen::Matrix<S, kDof, kDof>;

  SE2T() : data_{S(0), S(0), S(0)}, cos_(1), sin_(0) {}
  SE2T(const S& x, const S& y, const S& theta) : data_{x, y, theta} {
    using std::cos;
    using std::sin;
    cos_ = cos(theta);
    sin_ = sin(theta);
  }
  explicit SE2T(const S* params) : SE2T(params[0], params[1], params[2]) {}

  const S* data() const { return data_; }
  Eigen::Map<const Vector> translation() const { return Eigen::Map<const Vector>(data_); }
  Eigen::Map<Vector> translation() { return Eigen::Map<Vector>(data_); }
  const S& angle() const { return data_[2]; }
  RotationMatrix matrix() const {
    RotationMatrix r;
    r << cos_, -sin_, sin_, cos_;
    return r;
  }

  SE2T operator*(const SE2T& o) const {
    return SE2T(*this * Vector(o.translation()), data_[2] + o.data_[2],
                cos_ * o.cos_ - sin_ * o.sin_, sin_ * o.cos_ + cos_ * o.sin_);
  }
  Vector operator*(const Vector& p) const { return matrix() * p + translation(); }
  SE2T Inverse() const {
    return SE2T(-(matrix().transpose() * translation()), -data_[2], cos_, -sin_);
  }
  // *this^-1 * o.
  SE2T Between(const SE2T& o) const {
    return SE2T(matrix().transpose() * (o.translation() - translation()), o.data_[2] - data_[2],
                cos_ * o.cos_ + sin_ * o.sin_, cos_ * o.sin_ - sin_ * o.cos_);
  }
  SE2T Normalized() const { return SE2T(data_[0], data_[1], NormalizeAngle(data_[2])); }

  SE2T Retract(const Tangent& d) const {
    const Vector t = *this * Vector(d.template head<2>());
    return SE2T(t(0), t(1), NormalizeAngle(data_[2] + d(2)));
  }
  // The d for which this->Retract(d) == o.
  Tangent LocalCoordinates(const SE2T& o) const {
    const SE2T d = Between(o);
    return Tangent(d.data_[0], d.data_[1], d.data_[2]);
  }

  // The group exponential of the twist (v, omega), and its inverse.
  static SE2T Exp(const Tangent& d) {
    S a, b;
    Coefficients(d(2), &a, &b);
    return SE2T(a * d(0) - b * d(1), b * d(0) + a * d(1), NormalizeAngle(d(2)));
  }
  Tangent Log() const {
    S a, b;
    Coefficients(data_[2], &a, &b);
    const S k = S(1) / (a * a + b * b);
    return Tangent(k * (a * data_[0] + b * data_[1]), k * (a * data_[1] - b * data_[0]), data_[2]);
  }

  // *this * Exp(d), and the d for which x.Plus(d) == *this. Other than with Retract, the twists by
  // which a motion of the world moves two poses keep their relative pose, however far they go: in a
  // step of a solve, what moves as one stays rigid.
  SE2T Plus(const Tangent& d) const { return (*this * Exp(d)).Normalized(); }
  Tangent Minus(const SE2T& x) const { return x.Between(*this).Log(); }

  // T Exp(d) = Exp(Ad(T) d) T.
  Matrix Adjoint() const {
    Matrix m = Matrix::Identity();
    m.template topLeftCorner<2, 2>() = matrix();
    m(0, 2) = data_[1];
    m(1, 2) = -data_[0];
    return m;
  }
  // Ad(T^-1).
  Matrix InverseAdjoint() const {
    Matrix m = Matrix::Identity();
    m.template topLeftCorner<2, 2>() = matrix().transpose();
    const Vector t = m.template topLeftCorner<2, 2>() * translation();
    m(0, 2) = -t(1);
    m(1, 2) = t(0);
    return m;
  }

  template <typename N>
  SE2T<N> Cast() const {
    return SE2T<N>(N(data_[0]), N(data_[1]), N(data_[2]));
  }

  // What an archive needs to have the same bits again.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.data_, self.cos_, self.sin_);
  }

 private:
  // a = sin(w) / w, b = (1 - cos(w)) / w.
  static void Coefficients(const S& w, S* a, S* b) {
    using std::sin;
    const S w_sq = w * w;
    if (w_sq > S(1e-4)) {
      const S s = sin(S(0.5) * w);
      *a = sin(w) / w;
      *b = S(2) * s * s / w;  // 1 - cos(w) would cancel
    } else {
      *a = S(1) - w_sq * (S(1.0 / 6) - w_sq / S(120));
      *b = w * (S(0.5) - w_sq * (S(1.0 / 24) - w_sq / S(720)));
    }
  }

  SE2T(const Vector& t, const S& theta, const S& cos_theta, const S& sin_theta)
      : data_{t(0), t(1), NormalizeAngle(theta)}, cos_(cos_theta), sin_(sin_theta) {}

  S data_[kParams];
  S cos_, sin_;
};

using SE2 = SE2T<double>;

// Right Jacobian of the group: Exp(xi + d) ~ Exp(xi) Exp(Jr(xi) d); this is its inverse.
SE2::Matrix Se2RightJacobianInverse(const SE2::Tangent& xi);

}  // namespace ceres_costs
