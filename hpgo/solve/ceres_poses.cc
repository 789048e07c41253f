#include "hpgo/solve/ceres_poses.h"

#include <algorithm>
#include <string>

namespace hpgo {

using ceres_costs::JacobianKind;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

ceres::Problem::Options CeresPosesOptions() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  return options;
}

template <typename G>
Status CeresPoses<G>::Build(const Subproblem<G>& subproblem, ceres::Problem* problem) {
  relative_used_ = prior_used_ = 0;
  adapters_.clear();
  const int size = static_cast<int>(subproblem.poses.size());
  parameters_.resize(subproblem.poses.size() * G::kParams);
  for (int k = 0; k < size; ++k) {
    double* pose = Block(k);
    std::copy_n(subproblem.poses[k].data(), G::kParams, pose);
    problem->AddParameterBlock(pose, G::kParams, manifold_.get());
    if (k >= subproblem.num_free) problem->SetParameterBlockConstant(pose);
  }
  for (const Factor<G>& factor : subproblem.factors) {
    ceres::CostFunction* cost = CostOf(factor);
    if (cost == nullptr) {
      return Status(
          StatusCode::kInvalidArgument,
          "the factor between poses " + std::to_string(factor.i) + " and " +
              std::to_string(factor.j) +
              (factor.custom == nullptr ? ": information is not positive semi-definite"
                                        : ": the cost's parameter blocks are not these poses"));
    }
    auto* loss = const_cast<ceres::LossFunction*>(factor.loss);  // Ceres only evaluates it
    double* pose_j = Block(factor.j);
    if (factor.i == kWorldFrame) {
      problem->AddResidualBlock(cost, loss, pose_j);
    } else {
      problem->AddResidualBlock(cost, loss, Block(factor.i), pose_j);
    }
  }
  return Status::Ok();
}

// A cost of the pool that stands for the factor, or null if its values do not allow one.
template <typename G>
ceres::CostFunction* CeresPoses<G>::CostOf(const Factor<G>& factor) {
  const bool unary = factor.i == kWorldFrame;
  if (factor.custom != nullptr) {
    if (!ceres_costs::LocalJacobianCost<G>::IsOverPoses(*factor.custom)) return nullptr;
    if (factor.custom->parameter_block_sizes().size() != (unary ? 1u : 2u)) return nullptr;
    if (jacobians_ == JacobianKind::kAmbient) {
      return const_cast<ceres::CostFunction*>(factor.custom);  // Ceres only evaluates it
    }
    return &adapters_.emplace_back(factor.custom);
  }
  if (unary) {
    if (prior_used_ == priors_.size()) priors_.emplace_back(jacobians_);
    ceres_costs::PriorCost<G>& cost = priors_[prior_used_++];
    return cost.Reset(*factor.term, factor.offset, factor.convention) ? &cost : nullptr;
  }
  if (relative_used_ == relatives_.size()) relatives_.emplace_back(jacobians_);
  ceres_costs::RelativePoseCost<G>& cost = relatives_[relative_used_++];
  return cost.Reset(*factor.term, factor.convention) ? &cost : nullptr;
}

template class CeresPoses<SE2>;
template class CeresPoses<SE3>;
template class CeresPoses<YawPose>;

}  // namespace hpgo
