// A Subproblem as a ceres::Problem: what the Ceres engine solves, and what is given out of a level.
#pragma once

#include <deque>
#include <memory>
#include <vector>

#include "ceres/problem.h"
#include "ceres_costs/local_jacobian_cost.h"
#include "ceres_costs/manifolds.h"
#include "ceres_costs/prior_cost.h"
#include "ceres_costs/relative_pose_cost.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// Of a problem that owns nothing.
ceres::Problem::Options CeresPosesOptions();

// The blocks, costs and manifold of a problem, kept from one to the next. A block a pose, in the
// storage order of G, those that are not free constant; the objective of Ceres is half that of the
// Subproblem. Must outlive the problem.
template <typename G>
class CeresPoses {
 public:
  // kLocal is faster; others who add costs to the problem, or differentiate, want kAmbient.
  explicit CeresPoses(ceres_costs::JacobianKind jacobians)
      : jacobians_(jacobians), manifold_(ceres_costs::MakePoseManifold<G>(jacobians)) {}
  CeresPoses(const CeresPoses&) = delete;
  CeresPoses& operator=(const CeresPoses&) = delete;

  // Fills an empty problem made with CeresPosesOptions; custom costs and losses are borrowed. Ends
  // that of the last. kInvalidArgument where information is not positive semi-definite or a custom
  // cost is not over poses.
  Status Build(const Subproblem<G>& subproblem, ceres::Problem* problem);

  // The block of the pose k of the subproblem, and what is in it.
  double* Block(int k) { return &parameters_[static_cast<std::size_t>(k) * G::kParams]; }
  G Pose(int k) { return G(Block(k)); }

 private:
  ceres::CostFunction* CostOf(const Factor<G>& factor);

  const ceres_costs::JacobianKind jacobians_;
  const std::unique_ptr<ceres::Manifold> manifold_;
  std::vector<double> parameters_;  // of all poses
  // Deques: the problem holds pointers into them.
  std::deque<ceres_costs::RelativePoseCost<G>> relatives_;
  std::deque<ceres_costs::PriorCost<G>> priors_;
  std::deque<ceres_costs::LocalJacobianCost<G>> adapters_;
  std::size_t relative_used_ = 0, prior_used_ = 0;
};

extern template class CeresPoses<ceres_costs::SE2>;
extern template class CeresPoses<ceres_costs::SE3>;
extern template class CeresPoses<ceres_costs::YawPose>;

}  // namespace hpgo
