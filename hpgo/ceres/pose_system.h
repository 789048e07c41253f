// The Gauss-Newton system of a ceres::Problem whose blocks are poses, in blocks of the Hessian.
#pragma once

#include <memory>

#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/problem_view.h"
#include "hpgo/ceres/secant_pairs.h"

namespace hpgo {

// Works on a copy of the values, in the problem's own terms: the costs are evaluated where the
// blocks stand, their Jacobians go through PlusJacobian of the blocks' manifolds, steps through
// Plus. So nothing needs to be known of what the numbers of a pose mean, and costs whose Jacobians
// are made for their manifold alone are served. The cost is that of Ceres, sum rho(|r|^2) / 2.
// Not synchronized.
class PoseSystem {
 public:
  virtual ~PoseSystem() = default;

  // Of the residuals over constant blocks alone. NaN where one fails.
  virtual double FixedCost() = 0;
  // Fills the Hessian and the gradient at the current values. The cost of all other residuals; NaN
  // where one fails or something is not finite.
  virtual double Linearize() = 0;
  virtual double gradient_norm() const = 0;
  virtual double gradient_max_norm() const = 0;
  // Factors H + damping diag(H); false if that is not positive definite.
  virtual bool Factorize(double damping) = 0;
  // Finds the step of the damped system. By how much the model without damping decreases with it.
  virtual double FindStep(double damping) = 0;
  // Of the decrease that the step found promises: what damping weighs in it.
  virtual double damping_share() const = 0;
  // More damping than that of the step that was found, for one of a third of its length.
  virtual double ShrinkingDamping(double damping) = 0;
  // The same as FindStep with the matrix as the pairs correct it, without damping.
  virtual double FindSecantStep(const SecantPairs& pairs) = 0;
  // The step that was found and the gradient, as many numbers a pose that moves.
  virtual const std::vector<double>& step() const = 0;
  virtual const std::vector<double>& gradient() const = 0;
  // The derivative of the cost along the step, where it begins.
  virtual double Slope() const = 0;
  // The cost after a part of the step; NaN as above.
  virtual double Try(double part) = 0;
  // Of what was tried, and of the values before: Euclidean norms over the blocks that move.
  virtual double step_norm() const = 0;
  virtual double value_norm() const = 0;
  // Takes what was tried as the current values.
  virtual void Accept() = 0;
  // Writes the current values, or those of the beginning, into the blocks that move.
  virtual void WriteBack() const = 0;
  virtual void WriteBackInitial() const = 0;

  virtual int num_active_residual_blocks() const = 0;
  virtual int num_active_residuals() const = 0;
  virtual int num_active_blocks() const = 0;
  virtual int num_active_parameters() const = 0;
  virtual int num_active_dof() const = 0;
  virtual int num_free_poses() const = 0;
};

// Both arguments must outlive the system.
std::unique_ptr<PoseSystem> MakePoseSystem(const ProblemView& problem, const PoseBlocks& poses);

}  // namespace hpgo
