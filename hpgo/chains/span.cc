#include "hpgo/chains/span.h"

#include <algorithm>
#include <cmath>

#include "Eigen/Cholesky"
#include "ceres_costs/factor_term.h"
#include "hpgo/hierarchy/coarse_edge.h"

namespace hpgo {

using ceres_costs::PackedSymmetric;
using ceres_costs::QuadraticModel;
using ceres_costs::RelativePoseTerm;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

// Ad(T_b_c^-1): what a perturbation at b does at c.
template <typename G>
typename G::Matrix Transport(const G& T_b_c) {
  return T_b_c.InverseAdjoint();
}

// Of the error's Jacobian. At the half turn, where it is singular, a large one.
template <int N>
Eigen::Matrix<double, N, N> Inverse(const Eigen::Matrix<double, N, N>& J) {
  constexpr double kSingular = 1e-6;
  if (std::abs(J.determinant()) > kSingular) return J.inverse();
  return (J + 1e-2 * Eigen::Matrix<double, N, N>::Identity()).inverse();
}
template <typename G>
typename G::Matrix InverseJacobian(ceres_costs::ErrorConvention convention,
                                   const typename G::Matrix& J) {
  if constexpr (G::kRotationDof == 1) {
    if (convention == ceres_costs::ErrorConvention::kTwist) return Inverse<G::kDof>(J);
    return J.transpose();  // a rotation
  } else {
    const Eigen::Matrix3d inverse = Inverse<3>(J.template bottomRightCorner<3, 3>());
    typename G::Matrix B = G::Matrix::Zero();
    B.template bottomRightCorner<3, 3>() = inverse;
    if (convention == ceres_costs::ErrorConvention::kTwist) {  // of [A, D; 0, A]
      B.template topLeftCorner<3, 3>() = inverse;
      B.template topRightCorner<3, 3>() = -inverse * J.template topRightCorner<3, 3>() * inverse;
    } else {  // of a rotation, and of what the rotational error does
      B.template topLeftCorner<3, 3>() = J.template topLeftCorner<3, 3>().transpose();
    }
    return B;
  }
}

// As many errors as degrees of freedom: Y's best perturbation is -B e, with covariance B C B'.
template <typename G>
struct EdgeLinearization {
  EdgeLinearization(const EdgeMeasurement<G>& edge, const G& Y,
                    ceres_costs::ErrorConvention convention) {
    typename G::Matrix J;
    error =
        RelativePoseError(convention, edge.term.measurement, edge.reversed ? Y.Inverse() : Y, &J);
    B = InverseJacobian<G>(convention, J);
    // T_next_previous moves by -Ad(Y) d where Y moves by d.
    if (edge.reversed) B = -Transport(Y) * B;
  }
  typename G::Tangent error;
  typename G::Matrix B;
};

template <typename G>
typename G::Matrix Symmetric(const typename G::Matrix& m) {
  return 0.5 * (m + m.transpose());
}

}  // namespace

template <typename G>
void GrowingSpan<G>::Append(const EdgeMeasurement<G>& edge, const G& Y) {
  const EdgeLinearization<G> at(edge, Y, convention_);
  const typename G::Matrix M = Transport(Y);
  typename G::Matrix half;
  half.noalias() = M * covariance_;
  covariance_.noalias() = half * M.transpose();
  half.noalias() = at.B * edge.covariance.Dense();
  covariance_.noalias() += half * at.B.transpose();
  shift_ = (M * shift_ - at.B * at.error).eval();
  T_ = T_ * Y;
  cost_ += at.error.dot(edge.term.information.Dense() * at.error);
  length_ += Y.translation().norm();
}

template <typename G>
SpanModel<G> GrowingSpan<G>::Model() const {
  SpanModel<G> span;
  span.T = T_.Normalized();
  span.shift = shift_;
  span.covariance = PackedSymmetric<G::kDof>(Symmetric<G>(covariance_));
  span.cost = cost_;
  span.length = static_cast<float>(length_);
  return span;
}

template <typename G>
typename G::Tangent PullTowards(const SpanModel<G>& model, const G& T_a_b, Inside inside) {
  const typename G::Tangent d =
      inside == Inside::kMean ? typename G::Tangent(-ShiftAt(model, T_a_b)) : T_a_b.Minus(model.T);
  return model.covariance.Dense().llt().solve(d);
}

template <typename G>
EdgeYield<G>::EdgeYield(const EdgeMeasurement<G>& edge, const G& Y,
                        ceres_costs::ErrorConvention convention) {
  const EdgeLinearization<G> at(edge, Y, convention);
  error_ = at.error;
  B_ = at.B;
  covariance_ = &edge.covariance;
}

template <typename G>
typename G::Tangent EdgeYield<G>::Under(const typename G::Tangent& pull, Inside inside) const {
  typename G::Tangent moved = covariance_->Dense() * (B_.transpose() * pull);
  if (inside == Inside::kMean) moved -= error_;
  return B_ * moved;
}

template <typename G>
SpanModel<G> Join(const SpanModel<G>& first, const SpanModel<G>& second) {
  return Join(first, second, {first.T, second.T});
}

template <typename G>
SpanModel<G> Join(const SpanModel<G>& first, const SpanModel<G>& second, const SplitPose<G>& at) {
  const typename G::Matrix M = Transport(at.second);
  SpanModel<G> span;
  span.T = (at.first * at.second).Normalized();
  span.shift = M * ShiftAt(first, at.first) + ShiftAt(second, at.second);
  const typename G::Matrix covariance =
      M * first.covariance.Dense() * M.transpose() + second.covariance.Dense();
  span.covariance = PackedSymmetric<G::kDof>(Symmetric<G>(covariance));
  span.cost = first.cost + second.cost;
  span.length = first.length + second.length;
  return span;
}

template <typename G>
SplitPose<G> Distribute(const SpanModel<G>& first, const SpanModel<G>& second, const G& T_a_c,
                        Inside inside) {
  const typename G::Matrix M = Transport(second.T);
  typename G::Tangent shift = G::Tangent::Zero(), innovation = T_a_c.Minus(first.T * second.T);
  if (inside == Inside::kMean) {
    shift = first.shift;
    innovation -= M * first.shift + second.shift;
  }
  const typename G::Matrix gain = first.covariance.Dense() * M.transpose();
  const typename G::Matrix sum = M * gain + second.covariance.Dense();
  SplitPose<G> split;
  split.first = first.T.Plus(shift + gain * sum.llt().solve(innovation));
  split.second = split.first.Between(T_a_c);
  return split;
}

template <typename G>
double BendAt(const SpanModel<G>& model, const G& T) {
  constexpr double kShortest = 1e-9;  // m
  const typename G::Tangent d = T.Minus(model.T);
  return std::max(d.template tail<G::kRotationDof>().norm(),
                  d.template head<G::kDim>().norm() / std::max<double>(model.length, kShortest));
}

template <typename G>
double MissedAt(const SpanModel<G>& model, const G& T) {
  constexpr double kNothing = 1e-6;  // of a bend
  const double bend = BendAt(model, T);
  if (bend < kNothing) return 0;
  const Eigen::LLT<typename G::Matrix> llt(model.covariance.Dense());
  double deviation_sq = 0;
  for (const G* at : {&T, &model.T}) {
    const typename G::Tangent deviation = ShiftAt(model, *at);
    deviation_sq = std::max(deviation_sq, deviation.dot(llt.solve(deviation)));
  }
  return bend * std::sqrt(deviation_sq);
}

template <typename G>
double ChiSquareAt(const SpanModel<G>& model, const G& T) {
  const typename G::Tangent deviation = ShiftAt(model, T);
  return deviation.dot(model.covariance.Dense().llt().solve(deviation));
}

template <typename G>
double GainAt(const SpanModel<G>& model) {
  return model.cost - model.shift.dot(model.covariance.Dense().llt().solve(model.shift));
}

template <typename G>
double ChainWeight(const SpanModel<G>& model) {
  // Below 1 / chi2, the weight of an edge (ModularityWeight), unless its noise is of 1 mm or less.
  constexpr double kAfterEdges = 1e-9;
  constexpr double kLeastVariance = 1e-12;  // m^2, of what is all but exact
  const typename G::Matrix covariance = model.covariance.Dense();
  const double variance = covariance.template topLeftCorner<G::kDim, G::kDim>().trace();
  return kAfterEdges / std::max(variance, kLeastVariance);
}

template <typename G>
bool IsTwisted(const G& measurement, const G& T_i_j) {
  const typename G::Tangent d = T_i_j.Minus(measurement);
  return d.template tail<G::kRotationDof>().norm() > kReach;
}

template <typename G>
StepWithinReach<G> TowardsWithinReach(const SpanModel<G>& model, const G& T, double part) {
  const typename G::Tangent d = T.Minus(model.T);
  const double turn = d.template tail<G::kRotationDof>().norm();
  part *= std::min(1., kReach / turn);
  if (!(part < 1)) return {T, true};
  return {model.T.Plus(part * d), false};
}

template <typename G>
RelativePoseTerm<G> TermOfSpan(const SpanModel<G>& span, const G& T) {
  QuadraticModel<G> model;
  const typename G::Matrix covariance = span.covariance.Dense();
  model.A = Symmetric<G>(covariance.llt().solve(G::Matrix::Identity()));
  model.b = -model.A * ShiftAt(span, T);
  return TermFromModel(model, SemiDefiniteInverse<G>(model.A), T);
}

#define HPGO_INSTANTIATE(G)                                                                     \
  template class GrowingSpan<G>;                                                                \
  template G::Tangent PullTowards(const SpanModel<G>&, const G&, Inside);                       \
  template class EdgeYield<G>;                                                                  \
  template SpanModel<G> Join(const SpanModel<G>&, const SpanModel<G>&);                         \
  template SpanModel<G> Join(const SpanModel<G>&, const SpanModel<G>&, const SplitPose<G>&);    \
  template SplitPose<G> Distribute(const SpanModel<G>&, const SpanModel<G>&, const G&, Inside); \
  template double BendAt(const SpanModel<G>&, const G&);                                        \
  template double MissedAt(const SpanModel<G>&, const G&);                                      \
  template double ChiSquareAt(const SpanModel<G>&, const G&);                                   \
  template double GainAt(const SpanModel<G>&);                                                  \
  template double ChainWeight(const SpanModel<G>&);                                             \
  template bool IsTwisted(const G&, const G&);                                                  \
  template StepWithinReach<G> TowardsWithinReach(const SpanModel<G>&, const G&, double);        \
  template RelativePoseTerm<G> TermOfSpan(const SpanModel<G>&, const G&);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
