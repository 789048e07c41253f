// The Ceres cost of a relative pose measurement.
#pragma once

#include <memory>
#include <string>

#include "ceres/sized_cost_function.h"
#include "ceres_costs/manifolds.h"
#include "ceres_costs/relative_pose_error.h"

namespace ceres_costs {

enum class DiffMethod {
  kAnalytic,
  kAutomatic,  // by Jets: several times slower, the check of the analytic one
};

// r(X_i, X_j) = W e(Z^-1 X_i^-1 X_j), with Z a measurement of T_i_j and W' W its information, so
// that |r|^2 = e' Omega e. Parameter blocks {X_i, X_j}: T_world_i and T_world_j in the storage
// order of G. Evaluate is safe from several threads, Reset is not.
template <typename G>
class RelativePoseCost final : public ceres::SizedCostFunction<G::kDof, G::kParams, G::kParams> {
 public:
  // The identity, measured with information of the identity.
  explicit RelativePoseCost(JacobianKind jacobians = JacobianKind::kAmbient)
      : jacobians_(jacobians) {}

  // Makes it the cost of another measurement; solvers keep a pool of them. False, with the cost
  // unchanged, if the information is indefinite or not finite.
  [[nodiscard]] bool Reset(const RelativePoseTerm<G>& term, ErrorConvention convention);
  // The same with a known W; see WhitenInformation.
  void Reset(const G& measurement, const typename G::Matrix& whitening, ErrorConvention convention);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  JacobianKind jacobians_;
  ErrorConvention convention_ = ErrorConvention::kG2o;
  G measurement_;
  typename G::Matrix whitening_ = G::Matrix::Identity();
};

// RelativePoseCost, or its automatic twin. Null, with *error saying why, if the information is
// indefinite or not finite.
template <typename G>
std::unique_ptr<ceres::CostFunction> MakeRelativePoseCost(const RelativePoseTerm<G>& term,
                                                          ErrorConvention convention,
                                                          DiffMethod method, JacobianKind jacobians,
                                                          std::string* error);

// W of the term's information, or false with a message that holds the extreme eigenvalues.
template <typename G>
[[nodiscard]] bool WhitenTerm(const RelativePoseTerm<G>& term, typename G::Matrix* W,
                              std::string* error);

}  // namespace ceres_costs
