// What tells one cost from another.
#pragma once

#include <cstdint>

#include "ceres/cost_function.h"
#include "ceres/loss_function.h"

namespace hpgo {

// A number that tells one cost and loss from others, by their values at a few points: pointers that
// are freed recur. O(1).
std::uint64_t Fingerprint(const ceres::CostFunction& cost, const ceres::LossFunction* loss);

}  // namespace hpgo
