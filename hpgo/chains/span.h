// The mathematics of a chain of poses: a stretch of it as one relative-pose measurement.
#pragma once

#include "ceres_costs/packed_symmetric.h"
#include "ceres_costs/relative_pose_error.h"
#include "hpgo/hierarchy/level.h"

namespace hpgo {

// rad, of a turn by which a linearization says something.
inline constexpr double kReach = 0.5;

// rad, or m per m, by which a stretch may bend before it is looked into, on its way or for its
// cost.
inline constexpr double kFarOnTheWay = 0.05;

// rad, or m per m, by which a new node may bend the chain behind it where it is posed.
inline constexpr double kReachOfNewNode = 0.2;

// A stretch of a chain from its first node a to its last node b, the nodes between eliminated: the
// best relative pose of its ends, with the covariance of a right perturbation of T_a_b. Covariances
// add up along a chain, which keeps all digits; information does not (closure studies: 1e-13
// against 3e-4 after 100,000 edges). Equal to the Schur complement of the interior at the
// linearization point.
template <typename G>
struct SpanModel {
  G T;                                             // T_a_b where the edges were linearized
  typename G::Tangent shift = G::Tangent::Zero();  // the perturbation of T that the edges prefer
  ceres_costs::PackedSymmetric<G::kDof> covariance;
  double cost = 0;   // of the edges where they are linearized
  float length = 0;  // of the path at T, in m

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.T, self.shift, self.covariance, self.cost, self.length);
  }
};

// The perturbation of another T_a_b that the edges prefer.
template <typename G>
typename G::Tangent ShiftAt(const SpanModel<G>& model, const G& T) {
  return model.shift - T.Minus(model.T);
}

// An edge of a chain: its term, and the inverse of its information. `reversed`: the chain runs
// against the measurement, which is of T_next_previous. Owns nothing.
template <typename G>
struct EdgeMeasurement {
  const ceres_costs::RelativePoseTerm<G>& term;
  const ceres_costs::PackedSymmetric<G::kDof>& covariance;
  bool reversed = false;
};

// A stretch that grows edge by edge at its end, each linearized at its relative pose
// Y = T_previous_next along the chain.
template <typename G>
class GrowingSpan {
 public:
  explicit GrowingSpan(ceres_costs::ErrorConvention convention) : convention_(convention) {}
  void Append(const EdgeMeasurement<G>& edge, const G& Y);
  SpanModel<G> Model() const;

 private:
  ceres_costs::ErrorConvention convention_;
  G T_;
  typename G::Tangent shift_ = G::Tangent::Zero();
  typename G::Matrix covariance_ = G::Matrix::Zero();
  double cost_ = 0, length_ = 0;
};

// Where the inside of a stretch is, given its ends.
enum class Inside {
  kMean,   // the conditional mean: what its edges prefer
  kYields  // where they are linearized, but for what they yield to the ends
};

// The perturbation of T that brings the ends of a stretch to T_a_b, as a pull there: the gradient
// of the cost of the edges, halved.
template <typename G>
typename G::Tangent PullTowards(const SpanModel<G>& model, const G& T_a_b, Inside inside);

// How an edge at Y gives way.
template <typename G>
class EdgeYield {
 public:
  EdgeYield() = default;
  EdgeYield(const EdgeMeasurement<G>& edge, const G& Y, ceres_costs::ErrorConvention convention);
  // The perturbation of Y under a pull there: by which it yields, and which it prefers.
  typename G::Tangent Under(const typename G::Tangent& pull, Inside inside) const;

 private:
  typename G::Tangent error_;
  typename G::Matrix B_;  // the inverse of the error's Jacobian
  const ceres_costs::PackedSymmetric<G::kDof>* covariance_ = nullptr;
};

// T_a_b and T_b_c, where T_a_c is cut at b.
template <typename G>
struct SplitPose {
  G first, second;
};

// `first` then `second`, linearized where each of them is, or at `at`.
template <typename G>
SpanModel<G> Join(const SpanModel<G>& first, const SpanModel<G>& second);
template <typename G>
SpanModel<G> Join(const SpanModel<G>& first, const SpanModel<G>& second, const SplitPose<G>& at);

// The node between two stretches, given T_a_c of the outer ends.
template <typename G>
SplitPose<G> Distribute(const SpanModel<G>& first, const SpanModel<G>& second, const G& T_a_c,
                        Inside inside);

// How far T bends the stretch against where it was linearized: rad, or m per m of its length.
template <typename G>
double BendAt(const SpanModel<G>& model, const G& T);

// Whether it was linearized there, but for rounding.
template <typename G>
bool IsLinearizedAt(const SpanModel<G>& model, const G& T) {
  constexpr double kRounding = 1e-9;  // of a bend
  return !(BendAt(model, T) > kRounding);
}

// What the model may miss at T, in sqrt(chi2): the bend, times the whitened deviation from the
// mean, there or at T. Its covariance turns by the one, and pulls with the other; and what the mean
// was found by turns, too.
template <typename G>
double MissedAt(const SpanModel<G>& model, const G& T);

// What its edges cost with the ends at T, where they rest; as the model says.
template <typename G>
double ChiSquareAt(const SpanModel<G>& model, const G& T);

// What its edges would gain, in chi2, by a step of the nodes between its ends, where it was
// linearized.
template <typename G>
double GainAt(const SpanModel<G>& model);

// The weight of a chain where nodes are grouped: a group moves rigidly, and what is soft must not
// be inside one. So chains come after all edges of the graph, the stiffest first: by the inverse of
// the variance of their ends' positions, in 1 / m^2.
template <typename G>
double ChainWeight(const SpanModel<G>& model);

// Whether an edge is turned against its measurement by more than a linearization can reach.
template <typename G>
bool IsTwisted(const G& measurement, const G& T_i_j);

template <typename G>
struct StepWithinReach {
  G T;
  bool arrives = false;  // at the T asked for
};

// `part` of the way from where the model was linearized to T, or as much as a linearization can go.
template <typename G>
StepWithinReach<G> TowardsWithinReach(const SpanModel<G>& model, const G& T, double part);

// The model as a relative-pose term in the coarse convention, whose gradient and Hessian at T are
// those of the model.
template <typename G>
ceres_costs::RelativePoseTerm<G> TermOfSpan(const SpanModel<G>& model, const G& T);

}  // namespace hpgo
