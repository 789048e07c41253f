#include "hpgo/hierarchy/coarse_edge.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/symmetric_eigen.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {
namespace {

using ceres_costs::QuadraticModel;
using ceres_costs::RelativePoseTerm;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// The longest rotation of d: with one angle, that of the error, which wraps at pi; with three,
// twice the tangent of half of it, near which J^-1 grows beyond bounds, and with it the rounding of
// the information.
template <typename G>
constexpr double kMostRotation = G::kRotationDof == 1 ? 2.5 : 20;

// The deviation E whose error e fulfils e = J d, J its Jacobian, and J^-1.
template <typename G>
G Deviation(const typename G::Tangent& d, typename G::Matrix* J_inverse) {
  typename G::Tangent turn = G::Tangent::Zero();
  turn(G::kDim) = d(G::kDim);
  G E = G().Retract(turn);
  const typename G::RotationMatrix R = E.matrix();
  J_inverse->setIdentity();
  J_inverse->template topLeftCorner<G::kDim, G::kDim>() = R.transpose();
  E.translation() = R * d.template head<G::kDim>();
  return E;
}
// With three angles J = diag(R, (w I + [v]x) / 2) for the unit quaternion (w, v), so that (w, v) is
// along (1, d_rot / 2).
template <>
SE3 Deviation(const SE3::Tangent& d, SE3::Matrix* J_inverse) {
  const Eigen::Vector3d half = 0.5 * d.tail<3>();
  const double w = 1 / std::sqrt(1 + half.squaredNorm());
  const Eigen::Vector3d v = w * half;
  const Eigen::Quaterniond q(w, v(0), v(1), v(2));
  const Eigen::Matrix3d R = q.toRotationMatrix();
  J_inverse->setZero();
  J_inverse->topLeftCorner<3, 3>() = R.transpose();
  J_inverse->bottomRightCorner<3, 3>() = (2 / w) * v * v.transpose() - 2 * ceres_costs::Skew(v);
  J_inverse->bottomRightCorner<3, 3>().diagonal().array() += 2 * w;
  return SE3(R * d.head<3>(), q);
}
}  // namespace

template <typename G>
SemiDefiniteInverse<G>::SemiDefiniteInverse(const Matrix& A) {
  constexpr double kRounding = 1e-13;
  const double translation = A.diagonal().template head<G::kDim>().maxCoeff();
  const double rotation = A.diagonal().template tail<G::kRotationDof>().maxCoeff();
  for (int i = 0; i < G::kDof; ++i) {
    const double noise = kRounding * (i < G::kDim ? translation : rotation);
    scale_(i) = A(i, i) > std::max(noise, 0.) ? 1 / std::sqrt(A(i, i)) : 0;
  }
  // Rounding differs on the two sides of the diagonal.
  S_ = scale_.asDiagonal() * (0.5 * (A + A.transpose())) * scale_.asDiagonal();
  // The usual case: well conditioned after scaling.
  llt_.compute(S_);
  if (llt_.info() == Eigen::Success) {
    const Tangent diagonal = llt_.matrixLLT().diagonal();
    definite_ = diagonal.minCoeff() > 1e-5 * diagonal.maxCoeff();
  }
}

template <typename G>
typename G::Tangent SemiDefiniteInverse<G>::Times(const Tangent& b) const {
  const Tangent c = scale_.cwiseProduct(b);
  if (definite_) return scale_.cwiseProduct(llt_.solve(c));
  if (!S_.allFinite()) return Tangent::Zero();
  const auto eigen = ceres_costs::EigenOf<G::kDof>(S_);
  Tangent y = eigen.vectors.transpose() * c;
  for (int i = 0; i < G::kDof; ++i) {
    y(i) = eigen.values(i) > 1e-11 * eigen.values(G::kDof - 1) ? y(i) / eigen.values(i) : 0;
  }
  return scale_.cwiseProduct(eigen.vectors * y);
}

template <typename G>
typename G::Matrix SemiDefiniteInverse<G>::Root() const {
  if (!S_.allFinite()) return Matrix::Zero();
  const auto eigen = ceres_costs::EigenOf<G::kDof>(S_);
  const Tangent roots = eigen.values.cwiseMax(0).cwiseSqrt();
  const Tangent unscaled = (scale_.array() > 0).select(scale_.cwiseInverse(), 0);
  return roots.asDiagonal() * eigen.vectors.transpose() * unscaled.asDiagonal();
}

template <typename G>
bool IsWithinTerm(const typename G::Tangent& d) {
  return d.template tail<G::kRotationDof>().norm() <= kMostRotation<G>;
}

template <typename G>
RelativePoseTerm<G> TermFromModel(const QuadraticModel<G>& model,
                                  const SemiDefiniteInverse<G>& inverse, const G& T) {
  typename G::Tangent d = inverse.Times(model.b);
  const double rotation = d.template tail<G::kRotationDof>().norm();
  if (rotation > kMostRotation<G>) d *= kMostRotation<G> / rotation;
  typename G::Matrix J_inverse;
  const G E = Deviation<G>(d, &J_inverse);
  RelativePoseTerm<G> term;
  term.measurement = (T * E.Inverse()).Normalized();
  typename G::Matrix information;
  if (inverse.definite()) {
    information = J_inverse.transpose() * (0.5 * (model.A + model.A.transpose())) * J_inverse;
  } else {
    const typename G::Matrix W = inverse.Root() * J_inverse;
    information = W.transpose() * W;
  }
  term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
  return term;
}

template <typename G>
ChildGeometry<G>::ChildGeometry(const LevelEdge& edge, const LevelEdge& child,
                                const Level<G>& below, const G& T_g_h)
    : unary(child.node[0] == kNone),
      reversed(below.nodes[child.node[1]].parent != edge.node[1]),
      X_own(below.nodes[child.node[1]].pose) {
  if (!unary) X_a = below.nodes[child.node[0]].pose;
  X_b = reversed ? T_g_h.Between(X_own) : T_g_h * X_own;
}

template <typename G>
CoarseEdge<G> GalerkinEdge(const Hierarchy<G>& hierarchy, int l, Index edge) {
  const LevelEdge& record = hierarchy.level(l).edges[edge];
  const Level<G>& below = hierarchy.level(l - 1);
  CoarseEdge<G> result;
  result.T_g_h = hierarchy.RelativePose(l, record.node[0], record.node[1]);
  for (Index c = record.first_child; c != kNone; c = below.edges[c].next_sibling) {
    const ChildGeometry<G> child(record, below.edges[c], below, result.T_g_h);
    QuadraticModel<G> fine, coarse;
    if (!LinearizeFactor(hierarchy.FactorOf(l - 1, c), child.unary, child.RelativePose(), &fine)) {
      continue;
    }
    // Not reversed: T_g_h Exp(d) X_own moves b by Ad(X_own^-1) d. Reversed, a moves by Ad(X_a^-1)
    // d, which b sees as -Ad((X_a Y)^-1) d, and X_a Y is X_b.
    TransportModel((child.reversed ? child.X_b : child.X_own).Inverse(), fine, &coarse);
    result.model.A += coarse.A;
    if (child.reversed) {
      result.model.b -= coarse.b;
    } else {
      result.model.b += coarse.b;
    }
    result.model.cost += coarse.cost;
  }
  result.inverse = SemiDefiniteInverse<G>(result.model.A);
  result.term = TermFromModel(result.model, result.inverse, result.T_g_h);
  return result;
}

template <typename G>
double QuadraticChange(const CoarseEdge<G>& edge, const RelativePoseTerm<G>* old) {
  typename G::Tangent difference = edge.model.b;
  if (old != nullptr) {
    ceres_costs::FactorTerm<G> factor;
    factor.term = old;
    factor.convention = kCoarseConvention;
    QuadraticModel<G> model;
    LinearizeFactor(factor, false, edge.T_g_h, &model);
    difference -= model.b;
  }
  return std::sqrt(std::max(0., difference.dot(edge.inverse.Times(difference))));
}

template bool IsWithinTerm<SE2>(const SE2::Tangent&);
template bool IsWithinTerm<SE3>(const SE3::Tangent&);
template bool IsWithinTerm<YawPose>(const YawPose::Tangent&);
template RelativePoseTerm<SE2> TermFromModel(const QuadraticModel<SE2>&,
                                             const SemiDefiniteInverse<SE2>&, const SE2&);
template RelativePoseTerm<SE3> TermFromModel(const QuadraticModel<SE3>&,
                                             const SemiDefiniteInverse<SE3>&, const SE3&);
template RelativePoseTerm<YawPose> TermFromModel(const QuadraticModel<YawPose>&,
                                                 const SemiDefiniteInverse<YawPose>&,
                                                 const YawPose&);
template struct ChildGeometry<SE2>;
template struct ChildGeometry<SE3>;
template struct ChildGeometry<YawPose>;
template CoarseEdge<SE2> GalerkinEdge(const Hierarchy<SE2>&, int, Index);
template CoarseEdge<SE3> GalerkinEdge(const Hierarchy<SE3>&, int, Index);
template CoarseEdge<YawPose> GalerkinEdge(const Hierarchy<YawPose>&, int, Index);
template double QuadraticChange(const CoarseEdge<SE2>&, const RelativePoseTerm<SE2>*);
template double QuadraticChange(const CoarseEdge<SE3>&, const RelativePoseTerm<SE3>*);
template double QuadraticChange(const CoarseEdge<YawPose>&, const RelativePoseTerm<YawPose>*);
template class SemiDefiniteInverse<SE2>;
template class SemiDefiniteInverse<SE3>;
template class SemiDefiniteInverse<YawPose>;

}  // namespace hpgo
