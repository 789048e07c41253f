// The Ceres cost of a measurement of one pose.
#pragma once

#include <memory>
#include <string>

#include "ceres_costs/relative_pose_cost.h"

namespace ceres_costs {

// r(X) = W e(Z^-1 X P), with X = T_world_node, Z a measurement of T_world_sensor, P = T_node_sensor
// and W' W the information, rank-deficient where only part of the pose is measured. Parameter
// blocks {X}. With P the identity it is the relative pose cost of a measurement from the world
// frame. The translation of ErrorConvention::kTwist turns with the rotational error: partial
// measurements (a position without a heading) want kG2o or kSplitLog. Evaluate is safe from several
// threads, Reset is not.
template <typename G>
class PriorCost final : public ceres::SizedCostFunction<G::kDof, G::kParams> {
 public:
  // The identity, measured with information of the identity.
  explicit PriorCost(JacobianKind jacobians = JacobianKind::kAmbient) : jacobians_(jacobians) {}

  // As those of RelativePoseCost; `term.measurement` is Z and a null offset is the identity.
  [[nodiscard]] bool Reset(const RelativePoseTerm<G>& term, const G* offset,
                           ErrorConvention convention);
  void Reset(const G& measurement, const G* offset, const typename G::Matrix& whitening,
             ErrorConvention convention);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  JacobianKind jacobians_;
  ErrorConvention convention_ = ErrorConvention::kG2o;
  bool has_offset_ = false;
  G measurement_, offset_;
  typename G::Matrix offset_inverse_adjoint_;  // set with the offset
  typename G::Matrix whitening_ = G::Matrix::Identity();
};

// PriorCost, or its automatic twin. Null, with *error saying why, if the information is indefinite
// or not finite.
template <typename G>
std::unique_ptr<ceres::CostFunction> MakePriorCost(const RelativePoseTerm<G>& term, const G* offset,
                                                   ErrorConvention convention, DiffMethod method,
                                                   JacobianKind jacobians, std::string* error);

}  // namespace ceres_costs
