// Whether a cost over two poses is a function of their relative pose, as far as trying shows.
#pragma once

#include <string>

#include "ceres/cost_function.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace ceres_costs {

// Evaluates a cost over the blocks {X_i, X_j}, in the storage order of G, at T_i_j and near it, and
// again with both poses moved together. "its cost cannot be evaluated at the estimate", "its cost
// depends on more than T_i_j: ..."; empty if nothing is wrong. What is compared is the square of
// the residuals: they may turn with the frame.
template <typename G>
std::string CommonMotionProblem(const ceres::CostFunction& cost, const G& T_i_j);

}  // namespace ceres_costs
