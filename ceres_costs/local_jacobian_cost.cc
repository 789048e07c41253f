#include "ceres_costs/local_jacobian_cost.h"

#include <utility>

#include "glog/logging.h"

namespace ceres_costs {

template <typename G>
LocalJacobianCost<G>::LocalJacobianCost(const ceres::CostFunction* cost) : cost_(cost) {
  CHECK(IsOverPoses(*cost)) << "every parameter block must be a pose of " << G::kParams
                            << " numbers";
  *this->mutable_parameter_block_sizes() = cost->parameter_block_sizes();
  this->set_num_residuals(cost->num_residuals());
}

template <typename G>
LocalJacobianCost<G>::LocalJacobianCost(std::unique_ptr<const ceres::CostFunction> cost)
    : LocalJacobianCost(cost.get()) {
  owned_ = std::move(cost);
}

template <typename G>
bool LocalJacobianCost<G>::IsOverPoses(const ceres::CostFunction& cost) {
  for (const int size : cost.parameter_block_sizes()) {
    if (size != G::kParams) return false;
  }
  return !cost.parameter_block_sizes().empty();
}

template <typename G>
bool LocalJacobianCost<G>::Evaluate(double const* const* parameters, double* residuals,
                                    double** jacobians) const {
  if (!cost_->Evaluate(parameters, residuals, jacobians)) return false;
  if (jacobians == nullptr) return true;
  // In place, row by row: both Jacobians have rows of kParams numbers.
  using Row = Eigen::Matrix<double, 1, G::kParams>;
  for (std::size_t b = 0; b < this->parameter_block_sizes().size(); ++b) {
    if (jacobians[b] == nullptr) continue;
    const auto P = RetractionJacobian(G(parameters[b]));
    for (int k = 0; k < this->num_residuals(); ++k) {
      Eigen::Map<Row> row(jacobians[b] + k * G::kParams);
      const Eigen::Matrix<double, 1, G::kDof> local = row * P;
      row.setZero();
      row.template head<G::kDof>() = local;
    }
  }
  return true;
}

template class LocalJacobianCost<SE2>;
template class LocalJacobianCost<SE3>;
template class LocalJacobianCost<YawPose>;

}  // namespace ceres_costs
