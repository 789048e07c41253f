// Objects that a state refers to and that have no fields.
#pragma once

#include <memory>
#include <vector>

namespace ceres {
class CostFunction;
class LossFunction;
}  // namespace ceres

namespace hpgo {

// For a copy within the process: it shares them with what it was copied from.
struct StateObjects {
  std::vector<std::shared_ptr<const ceres::LossFunction>> losses;
  std::vector<std::shared_ptr<const ceres::CostFunction>> costs;
};

}  // namespace hpgo
