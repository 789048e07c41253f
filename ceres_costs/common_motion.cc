#include "ceres_costs/common_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace ceres_costs {
namespace {

// NaN where it cannot be evaluated.
template <typename G>
double SquaredNorm(const ceres::CostFunction& cost, const G& X_i, const G& X_j) {
  const double* parameters[2] = {X_i.data(), X_j.data()};
  Eigen::VectorXd residuals(cost.num_residuals());
  if (!cost.Evaluate(parameters, residuals.data(), nullptr)) {
    return std::numeric_limits<double>::quiet_NaN();
  }
  return residuals.squaredNorm();
}

// Turned against the angle of T, so that no sum of angles leaves [-pi, pi]: a cost may not wrap it.
template <typename G>
G Motion(const typename G::Tangent& d, const G& T_i_j) {
  typename G::Tangent away = d;
  if constexpr (G::kRotationDof == 1) {
    away(G::kDim) = std::copysign(d(G::kDim), -T_i_j.angle());
  }
  return G().Retract(away);
}

}  // namespace

template <typename G>
std::string CommonMotionProblem(const ceres::CostFunction& cost, const G& T_i_j) {
  using Tangent = typename G::Tangent;
  // Of what the cost changes when one pose moves alone: less is rounding.
  constexpr double kTolerance = 1e-8;
  Tangent shift = Tangent::Zero(), turn = Tangent::Zero(), both;
  for (int k = 0; k < G::kDof; ++k) {
    (k < G::kDim ? shift : turn)(k) = 0.9 - 0.25 * k;
    both(k) = k % 2 == 0 ? -0.7 : 0.55;
  }
  for (const double off : {0., 0.1, 1.}) {
    const G T = T_i_j * Motion<G>(off * both, T_i_j);
    const double alone = SquaredNorm(cost, G(), T);
    if (!std::isfinite(alone)) {
      if (off > 0) continue;
      return "its cost cannot be evaluated at the estimate";
    }
    const G motions[3] = {Motion<G>(3 * shift, T_i_j), Motion<G>(turn, T_i_j),
                          Motion<G>(both, T_i_j)};
    double change = 0;
    for (const G& M : motions) {
      const double moved = SquaredNorm(cost, G(), G(T * M));
      if (std::isfinite(moved)) change = std::max(change, std::abs(moved - alone));
    }
    for (const G& M : motions) {
      const double together = SquaredNorm(cost, M, G(M * T));
      if (std::abs(together - alone) <= kTolerance * (alone + change)) continue;
      std::ostringstream message;
      message << "its cost depends on more than T_i_j: " << alone << ", and " << together
              << " with both poses moved together";
      return message.str();
    }
  }
  return "";
}

template std::string CommonMotionProblem(const ceres::CostFunction&, const SE2&);
template std::string CommonMotionProblem(const ceres::CostFunction&, const SE3&);
template std::string CommonMotionProblem(const ceres::CostFunction&, const YawPose&);

}  // namespace ceres_costs
