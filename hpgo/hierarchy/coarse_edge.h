// The coarse edge between two groups, computed from the edges between their members.
#pragma once

#include "Eigen/Cholesky"
#include "ceres_costs/factor_term.h"
#include "hpgo/hierarchy/level.h"

namespace hpgo {

template <typename G>
class Hierarchy;

// That of coarse edges. Its rotation part has a Jacobian without trigonometry, and reaches any
// model whose minimum is less than half a turn away.
inline constexpr ceres_costs::ErrorConvention kCoarseConvention =
    ceres_costs::ErrorConvention::kG2o;

// Where the ends of an edge between members of two groups are.
template <typename G>
struct ChildGeometry {
  bool unary = false;     // a prior: the first end is the world frame
  bool reversed = false;  // the second end is a member of the first group
  G X_a, X_b;             // the ends, seen from the group of the first
  G X_own;                // the second end, seen from its own group

  // T_g_h: the relative pose of the groups that the edge's parent `edge` connects.
  ChildGeometry(const LevelEdge& edge, const LevelEdge& child, const Level<G>& below,
                const G& T_g_h);
  G RelativePose() const { return X_a.Between(X_b); }
};

// The pseudo-inverse of a positive semi-definite A, scaled by its diagonal, in which entries that
// are rounding beside the largest of their kind (translation, rotation) count as zero; directions
// below 1e-11 of the largest are dropped.
template <typename G>
class SemiDefiniteInverse {
 public:
  using Matrix = typename G::Matrix;
  using Tangent = typename G::Tangent;

  SemiDefiniteInverse() = default;
  explicit SemiDefiniteInverse(const Matrix& A);
  Tangent Times(const Tangent& b) const;
  bool definite() const { return definite_; }
  // W with W' W = A to rounding. What is made as a product of W with itself is semi-definite on
  // every scale, where sums in A leave noise beside the zeros of what is not measured.
  Matrix Root() const;

 private:
  Tangent scale_ = Tangent::Zero();
  Matrix S_ = Matrix::Zero();
  Eigen::LLT<Matrix> llt_;
  bool definite_ = false;
};

// A measurement of T_g_h in the coarse convention, and the quadratic model it was made from.
template <typename G>
struct CoarseEdge {
  ceres_costs::RelativePoseTerm<G> term;
  ceres_costs::QuadraticModel<G> model;  // at T_g_h, under a right perturbation of the group h
  SemiDefiniteInverse<G> inverse;        // of model.A
  G T_g_h;                               // the current estimate
};

// The exact restriction: the children of `edge` (of level l >= 1) evaluated at the current
// estimate, as functions of a rigid correction of the second group. Gradient and Hessian of the
// result equal the children's.
template <typename G>
CoarseEdge<G> GalerkinEdge(const Hierarchy<G>& hierarchy, int l, Index edge);

// The condensed measurement of the paper (section III, after its reference [8]): the local subgraph
// of the two groups is optimized with one representative held, and the other representative's mean
// and marginal covariance become the measurement, moved to the groups' frames. Of a centred edge
// (LevelEdge) the mean is the current relative pose instead.
template <typename G>
CoarseEdge<G> CondensedEdge(const Hierarchy<G>& hierarchy, int l, Index edge);

// Whether TermFromModel can say that a model prefers T moved by d: not where that turns so far that
// an error is about to wrap.
template <typename G>
bool IsWithinTerm(const typename G::Tangent& d);

// The measurement whose gradient and Hessian at T are those of `model`, `inverse` that of its A:
// with d = A^-1 b, an error e = J d, where J is the Jacobian at that error, and d shortened to what
// IsWithinTerm. Directions without information stay without.
template <typename G>
ceres_costs::RelativePoseTerm<G> TermFromModel(const ceres_costs::QuadraticModel<G>& model,
                                               const SemiDefiniteInverse<G>& inverse, const G& T);

// How much the gradient differs from that of the `old` term (null: none) at the same estimate:
// sqrt(db' A^-1 db), in sqrt(chi2).
template <typename G>
double QuadraticChange(const CoarseEdge<G>& edge, const ceres_costs::RelativePoseTerm<G>* old);

}  // namespace hpgo
