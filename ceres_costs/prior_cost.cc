#include "ceres_costs/prior_cost.h"

#include "ceres/autodiff_cost_function.h"
#include "ceres_costs/local_jacobian_cost.h"
#include "ceres_costs/whitening.h"

namespace ceres_costs {
namespace {

// The residual of PriorCost over any scalar.
template <template <typename> class GroupT>
struct PriorResidual {
  using G = GroupT<double>;

  template <typename S>
  bool operator()(const S* x, S* residuals) const {
    const GroupT<S> D =
        measurement.template Cast<S>().Between(GroupT<S>(x) * offset.template Cast<S>());
    ApplyWhitening(whitening, DeviationError(convention, D), residuals);
    return true;
  }

  G measurement, offset;
  typename G::Matrix whitening;
  ErrorConvention convention;
};

template <template <typename> class GroupT>
std::unique_ptr<ceres::CostFunction> MakeAutomatic(const GroupT<double>& measurement,
                                                   const GroupT<double>& offset,
                                                   const typename GroupT<double>::Matrix& whitening,
                                                   ErrorConvention convention) {
  using G = GroupT<double>;
  using Residual = PriorResidual<GroupT>;
  return std::make_unique<ceres::AutoDiffCostFunction<Residual, G::kDof, G::kParams>>(
      new Residual{measurement, offset, whitening, convention});
}

}  // namespace

template <typename G>
bool PriorCost<G>::Reset(const RelativePoseTerm<G>& term, const G* offset,
                         ErrorConvention convention) {
  typename G::Matrix W;
  if (!WhitenInformation<G::kDof>(term.information.Dense(), &W)) return false;
  Reset(term.measurement, offset, W, convention);
  return true;
}

template <typename G>
void PriorCost<G>::Reset(const G& measurement, const G* offset, const typename G::Matrix& whitening,
                         ErrorConvention convention) {
  convention_ = convention;
  has_offset_ = offset != nullptr;
  if (has_offset_) {
    offset_ = *offset;
    offset_inverse_adjoint_ = offset->InverseAdjoint();
  }
  measurement_ = measurement;
  whitening_ = whitening;
}

template <typename G>
bool PriorCost<G>::Evaluate(double const* const* parameters, double* residuals,
                            double** jacobians) const {
  const G X(parameters[0]);
  const bool wanted = jacobians != nullptr && jacobians[0] != nullptr;
  typename G::Matrix J;
  const typename G::Tangent e = RelativePoseError(
      convention_, measurement_, has_offset_ ? X * offset_ : X, wanted ? &J : nullptr);
  Eigen::Map<typename G::Tangent> r(residuals);
  r.noalias() = whitening_ * e;
  if (!wanted) return true;

  typename G::Matrix WJ;
  WJ.noalias() = whitening_ * J;
  // X Exp(d) P = X P Exp(Ad(P^-1) d).
  if (has_offset_) WJ = WJ * offset_inverse_adjoint_;
  WriteJacobian(jacobians_, X, WJ, jacobians[0]);
  return true;
}

template <typename G>
std::unique_ptr<ceres::CostFunction> MakePriorCost(const RelativePoseTerm<G>& term, const G* offset,
                                                   ErrorConvention convention, DiffMethod method,
                                                   JacobianKind jacobians, std::string* error) {
  typename G::Matrix W;
  if (!WhitenTerm(term, &W, error)) return nullptr;
  if (method == DiffMethod::kAnalytic) {
    auto cost = std::make_unique<PriorCost<G>>(jacobians);
    cost->Reset(term.measurement, offset, W, convention);
    return cost;
  }
  std::unique_ptr<ceres::CostFunction> cost =
      MakeAutomatic(term.measurement, offset == nullptr ? G() : *offset, W, convention);
  if (jacobians == JacobianKind::kAmbient) return cost;
  return std::make_unique<LocalJacobianCost<G>>(std::move(cost));
}

template class PriorCost<SE2>;
template class PriorCost<SE3>;
template class PriorCost<YawPose>;
template std::unique_ptr<ceres::CostFunction> MakePriorCost(const RelativePoseTerm<SE2>&,
                                                            const SE2*, ErrorConvention, DiffMethod,
                                                            JacobianKind, std::string*);
template std::unique_ptr<ceres::CostFunction> MakePriorCost(const RelativePoseTerm<SE3>&,
                                                            const SE3*, ErrorConvention, DiffMethod,
                                                            JacobianKind, std::string*);
template std::unique_ptr<ceres::CostFunction> MakePriorCost(const RelativePoseTerm<YawPose>&,
                                                            const YawPose*, ErrorConvention,
                                                            DiffMethod, JacobianKind, std::string*);

}  // namespace ceres_costs
