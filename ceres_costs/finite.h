#pragma once

#include "Eigen/Core"

namespace ceres_costs {

// Whether all stored parameters of a pose of any group are finite.
template <typename G>
bool IsFinite(const G& pose) {
  return Eigen::Map<const Eigen::Matrix<double, G::kParams, 1>>(pose.data()).allFinite();
}

}  // namespace ceres_costs
