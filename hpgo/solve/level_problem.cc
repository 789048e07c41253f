#include "hpgo/solve/level_problem.h"

#include <string>

#include "hpgo/solve/window.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
Result<std::shared_ptr<CeresLevel<G>>> CeresLevel<G>::Make(int level, Hierarchy<G>* hierarchy) {
  if (level < 0 || level >= hierarchy->num_levels()) {
    return Status(StatusCode::kInvalidArgument, "there is no level " + std::to_string(level) +
                                                    " of " +
                                                    std::to_string(hierarchy->num_levels()));
  }
  Window<G> window;
  window.BuildWhole(level, hierarchy);
  const std::shared_ptr<CeresLevel> result(new CeresLevel(level));
  result->problem_ = std::make_unique<ceres::Problem>(CeresPosesOptions());
  const Status status = result->poses_.Build(window.subproblem(), result->problem_.get());
  if (!status.ok()) return status;
  for (std::size_t k = 0; k < window.nodes().size(); ++k) {
    result->nodes_.push_back({window.nodes()[k], result->poses_.Block(static_cast<int>(k))});
    result->block_of_[window.nodes()[k]] = result->nodes_.back().block;
  }
  result->edges_ = window.edges();
  return result;
}

template <typename G>
double* CeresLevel<G>::BlockOf(Index index) const {
  const auto it = block_of_.find(index);
  return it == block_of_.end() ? nullptr : it->second;
}

template class CeresLevel<SE2>;
template class CeresLevel<SE3>;
template class CeresLevel<YawPose>;

}  // namespace hpgo
