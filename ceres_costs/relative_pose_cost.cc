#include "ceres_costs/relative_pose_cost.h"

#include <sstream>

#include "ceres/autodiff_cost_function.h"
#include "ceres_costs/local_jacobian_cost.h"
#include "ceres_costs/whitening.h"

namespace ceres_costs {
namespace {

// The residual of RelativePoseCost over any scalar.
template <template <typename> class GroupT>
struct RelativePoseResidual {
  using G = GroupT<double>;

  template <typename S>
  bool operator()(const S* x_i, const S* x_j, S* residuals) const {
    const GroupT<S> D =
        measurement.template Cast<S>().Between(GroupT<S>(x_i).Between(GroupT<S>(x_j)));
    ApplyWhitening(whitening, DeviationError(convention, D), residuals);
    return true;
  }

  G measurement;
  typename G::Matrix whitening;
  ErrorConvention convention;
};

template <template <typename> class GroupT>
std::unique_ptr<ceres::CostFunction> MakeAutomatic(const GroupT<double>& measurement,
                                                   const typename GroupT<double>::Matrix& whitening,
                                                   ErrorConvention convention) {
  using G = GroupT<double>;
  using Residual = RelativePoseResidual<GroupT>;
  return std::make_unique<ceres::AutoDiffCostFunction<Residual, G::kDof, G::kParams, G::kParams>>(
      new Residual{measurement, whitening, convention});
}

}  // namespace

template <typename G>
bool RelativePoseCost<G>::Reset(const RelativePoseTerm<G>& term, ErrorConvention convention) {
  if (!WhitenInformation<G::kDof>(term.information.Dense(), &whitening_)) return false;
  convention_ = convention;
  measurement_ = term.measurement;
  return true;
}

template <typename G>
void RelativePoseCost<G>::Reset(const G& measurement, const typename G::Matrix& whitening,
                                ErrorConvention convention) {
  convention_ = convention;
  measurement_ = measurement;
  whitening_ = whitening;
}

template <typename G>
bool RelativePoseCost<G>::Evaluate(double const* const* parameters, double* residuals,
                                   double** jacobians) const {
  const G X_i(parameters[0]), X_j(parameters[1]), T_i_j = X_i.Between(X_j);
  typename G::Matrix J_j;
  const typename G::Tangent e =
      RelativePoseError(convention_, measurement_, T_i_j, jacobians == nullptr ? nullptr : &J_j);
  Eigen::Map<typename G::Tangent> r(residuals);
  r.noalias() = whitening_ * e;
  if (jacobians == nullptr) return true;

  typename G::Matrix WJ_j;
  WJ_j.noalias() = whitening_ * J_j;
  if (jacobians[1] != nullptr) WriteJacobian(jacobians_, X_j, WJ_j, jacobians[1]);
  if (jacobians[0] != nullptr) {
    typename G::Matrix WJ_i;
    WJ_i.noalias() = -WJ_j * T_i_j.InverseAdjoint();
    WriteJacobian(jacobians_, X_i, WJ_i, jacobians[0]);
  }
  return true;
}

template <typename G>
std::unique_ptr<ceres::CostFunction> MakeRelativePoseCost(const RelativePoseTerm<G>& term,
                                                          ErrorConvention convention,
                                                          DiffMethod method, JacobianKind jacobians,
                                                          std::string* error) {
  typename G::Matrix W;
  if (!WhitenTerm(term, &W, error)) return nullptr;
  if (method == DiffMethod::kAnalytic) {
    auto cost = std::make_unique<RelativePoseCost<G>>(jacobians);
    cost->Reset(term.measurement, W, convention);
    return cost;
  }
  std::unique_ptr<ceres::CostFunction> cost = MakeAutomatic(term.measurement, W, convention);
  if (jacobians == JacobianKind::kAmbient) return cost;
  return std::make_unique<LocalJacobianCost<G>>(std::move(cost));
}

template <typename G>
bool WhitenTerm(const RelativePoseTerm<G>& term, typename G::Matrix* W, std::string* error) {
  const typename G::Matrix information = term.information.Dense();
  if (WhitenInformation<G::kDof>(information, W)) return true;
  *error = InformationProblem<G::kDof>(information);
  return false;
}

template class RelativePoseCost<SE2>;
template class RelativePoseCost<SE3>;
template class RelativePoseCost<YawPose>;
template std::unique_ptr<ceres::CostFunction> MakeRelativePoseCost(const RelativePoseTerm<SE2>&,
                                                                   ErrorConvention, DiffMethod,
                                                                   JacobianKind, std::string*);
template std::unique_ptr<ceres::CostFunction> MakeRelativePoseCost(const RelativePoseTerm<SE3>&,
                                                                   ErrorConvention, DiffMethod,
                                                                   JacobianKind, std::string*);
template std::unique_ptr<ceres::CostFunction> MakeRelativePoseCost(const RelativePoseTerm<YawPose>&,
                                                                   ErrorConvention, DiffMethod,
                                                                   JacobianKind, std::string*);
template bool WhitenTerm(const RelativePoseTerm<SE2>&, SE2::Matrix*, std::string*);
template bool WhitenTerm(const RelativePoseTerm<SE3>&, SE3::Matrix*, std::string*);
template bool WhitenTerm(const RelativePoseTerm<YawPose>&, YawPose::Matrix*, std::string*);

}  // namespace ceres_costs
