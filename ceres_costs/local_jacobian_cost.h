// Any cost over poses as one that goes with LocalPoseManifold.
#pragma once

#include <memory>

#include "ceres/cost_function.h"
#include "ceres_costs/manifolds.h"

namespace ceres_costs {

// The residuals of another cost over poses, its Jacobians by the stored parameters turned into
// local ones (JacobianKind::kLocal). Evaluate is safe from several threads if that of the other
// cost is.
template <typename G>
class LocalJacobianCost final : public ceres::CostFunction {
 public:
  // Borrows the cost, which must outlive this. IsOverPoses must hold.
  explicit LocalJacobianCost(const ceres::CostFunction* cost);
  // Owns it.
  explicit LocalJacobianCost(std::unique_ptr<const ceres::CostFunction> cost);

  // True if every parameter block has the size of a pose and there is one at least.
  static bool IsOverPoses(const ceres::CostFunction& cost);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  std::unique_ptr<const ceres::CostFunction> owned_;
  const ceres::CostFunction* cost_;
};

}  // namespace ceres_costs
