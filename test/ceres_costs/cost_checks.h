// What every cost over poses must satisfy: its Jacobians against numeric differentiation, its twins
// against one another.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ceres/cost_function.h"
#include "ceres/gradient_checker.h"
#include "ceres_costs/manifolds.h"
#include "test/ceres_costs/samples.h"

namespace ceres_costs {

// What a cost says at some poses: residuals, and a row-major Jacobian a block.
template <typename G>
struct Evaluation {
  Eigen::VectorXd residuals;
  std::vector<Eigen::Matrix<double, Eigen::Dynamic, G::kParams, Eigen::RowMajor>> jacobians;
};

template <typename G>
Evaluation<G> Evaluate(const ceres::CostFunction& cost, const std::vector<G>& poses) {
  Evaluation<G> result;
  result.residuals.setConstant(cost.num_residuals(), std::nan(""));
  result.jacobians.resize(poses.size());
  std::vector<const double*> parameters;
  std::vector<double*> jacobians;
  for (std::size_t b = 0; b < poses.size(); ++b) {
    result.jacobians[b].setConstant(cost.num_residuals(), G::kParams, std::nan(""));
    parameters.push_back(poses[b].data());
    jacobians.push_back(result.jacobians[b].data());
  }
  EXPECT_TRUE(cost.Evaluate(parameters.data(), result.residuals.data(), jacobians.data()));
  return result;
}

// The residuals alone, as Ceres asks for them.
template <typename G>
Eigen::VectorXd Residuals(const ceres::CostFunction& cost, const std::vector<G>& poses) {
  std::vector<const double*> parameters;
  for (const G& pose : poses) parameters.push_back(pose.data());
  Eigen::VectorXd residuals = Eigen::VectorXd::Constant(cost.num_residuals(), std::nan(""));
  EXPECT_TRUE(cost.Evaluate(parameters.data(), residuals.data(), nullptr));
  return residuals;
}

template <typename Jacobian>
double Scale(const Jacobian& J) {
  return std::max(1.0, J.cwiseAbs().maxCoeff());
}

// Two costs by the stored parameters: equal residuals, and Jacobians equal to `tolerance` on the
// tangent space (across it, in the direction of a quaternion's length, both are free).
template <typename G>
void ExpectTwins(const ceres::CostFunction& a, const ceres::CostFunction& b,
                 const std::vector<G>& poses, double tolerance) {
  const Evaluation<G> at_a = Evaluate(a, poses), at_b = Evaluate(b, poses);
  EXPECT_TRUE(IsNear(at_a.residuals, at_b.residuals, tolerance * Scale(at_a.residuals)));
  EXPECT_TRUE(IsNear(at_a.residuals, Residuals(a, poses), 0));
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const auto P = RetractionJacobian(poses[k]);
    EXPECT_TRUE(
        IsNear(at_a.jacobians[k] * P, at_b.jacobians[k] * P, tolerance * Scale(at_a.jacobians[k])))
        << "block " << k;
  }
}

// A cost by the tangent against the same by the stored parameters.
template <typename G>
void ExpectLocalOf(const ceres::CostFunction& ambient, const ceres::CostFunction& local,
                   const std::vector<G>& poses, double tolerance) {
  const Evaluation<G> from = Evaluate(ambient, poses), to = Evaluate(local, poses);
  EXPECT_TRUE(IsNear(from.residuals, to.residuals, tolerance * Scale(from.residuals)));
  for (std::size_t k = 0; k < poses.size(); ++k) {
    EXPECT_TRUE(IsNear(from.jacobians[k] * RetractionJacobian(poses[k]),
                       to.jacobians[k].template leftCols<G::kDof>(),
                       tolerance * Scale(from.jacobians[k])))
        << "block " << k;
    for (int c = G::kDof; c < G::kParams; ++c) EXPECT_EQ(to.jacobians[k].col(c).norm(), 0);
  }
}

// Central differences along the retraction.
template <typename G>
void ExpectNumericJacobians(const ceres::CostFunction& local, const std::vector<G>& poses,
                            double tolerance) {
  const double h = 1e-5;
  const Evaluation<G> at = Evaluate(local, poses);
  for (std::size_t b = 0; b < poses.size(); ++b) {
    Eigen::Matrix<double, Eigen::Dynamic, G::kDof> numeric(local.num_residuals(), int{G::kDof});
    for (int k = 0; k < G::kDof; ++k) {
      std::vector<G> ahead = poses, behind = poses;
      ahead[b] = poses[b].Retract(h * G::Tangent::Unit(k));
      behind[b] = poses[b].Retract(-h * G::Tangent::Unit(k));
      numeric.col(k) = (Residuals(local, ahead) - Residuals(local, behind)) / (2 * h);
    }
    EXPECT_TRUE(
        IsNear(at.jacobians[b].template leftCols<G::kDof>(), numeric, tolerance * Scale(numeric)))
        << "block " << b;
  }
}

// Ceres' own checker, with the manifold. Its steps are wide: keep away from where angles wrap.
template <typename G>
void ExpectGradientCheckerAgrees(const ceres::CostFunction& ambient, const std::vector<G>& poses,
                                 double tolerance) {
  const PoseManifold<G> manifold;
  const std::vector<const ceres::Manifold*> manifolds(poses.size(), &manifold);
  std::vector<const double*> parameters;
  for (const G& pose : poses) parameters.push_back(pose.data());
  ceres::NumericDiffOptions options;
  options.ridders_relative_initial_step_size = 1e-3;
  ceres::GradientChecker checker(&ambient, &manifolds, options);
  ceres::GradientChecker::ProbeResults results;
  // Probe's own verdict is relative to each entry, of which some are zero but for rounding.
  static_cast<void>(checker.Probe(parameters.data(), tolerance, &results));
  ASSERT_TRUE(results.return_value) << results.error_log;
  for (std::size_t b = 0; b < poses.size(); ++b) {
    const auto& numeric = results.local_numeric_jacobians[b];
    EXPECT_TRUE(IsNear(results.local_jacobians[b], numeric, tolerance * Scale(numeric)))
        << "block " << b;
  }
}

}  // namespace ceres_costs
