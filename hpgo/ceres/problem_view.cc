#include "hpgo/ceres/problem_view.h"

#include <limits>
#include <unordered_map>

#include "ceres/cost_function.h"
#include "ceres/manifold.h"

namespace hpgo {

bool IsBounded(const ceres::Problem& problem, const double* values, int size) {
  constexpr double kNone = std::numeric_limits<double>::max();
  for (int k = 0; k < size; ++k) {
    if (problem.GetParameterLowerBound(values, k) > -kNone ||
        problem.GetParameterUpperBound(values, k) < kNone) {
      return true;
    }
  }
  return false;
}

ProblemView::ProblemView(const ceres::Problem& problem) {
  std::vector<double*> parameters;
  problem.GetParameterBlocks(&parameters);
  std::unordered_map<const double*, int> index_of(2 * parameters.size());
  blocks_.reserve(parameters.size());
  for (double* values : parameters) {
    BlockView block;
    block.values = values;
    block.size = problem.ParameterBlockSize(values);
    block.manifold = problem.GetManifold(values);
    block.tangent = block.manifold == nullptr ? block.size : block.manifold->TangentSize();
    block.constant = problem.IsParameterBlockConstant(values);
    block.bounded = !block.constant && IsBounded(problem, values, block.size);
    block.offset = num_values_;
    num_values_ += block.size;
    index_of.emplace(values, static_cast<int>(blocks_.size()));
    blocks_.push_back(block);
  }
  std::vector<ceres::ResidualBlockId> ids;
  problem.GetResidualBlocks(&ids);
  residuals_.reserve(ids.size());
  for (const ceres::ResidualBlockId id : ids) {
    ResidualView residual;
    residual.id = id;
    residual.cost = problem.GetCostFunctionForResidualBlock(id);
    residual.loss = problem.GetLossFunctionForResidualBlock(id);
    residual.first = static_cast<int>(indices_.size());
    problem.GetParameterBlocksForResidualBlock(id, &parameters);
    residual.count = static_cast<int>(parameters.size());
    for (const double* values : parameters) {
      const int index = index_of.at(values);
      blocks_[index].used = true;
      indices_.push_back(index);
    }
    num_residuals_ += residual.cost->num_residuals();
    residuals_.push_back(residual);
  }
}

std::string ProblemView::NameOf(int block) const {
  const std::string size = " (size " + std::to_string(blocks_[block].size) + ")";
  for (std::size_t r = 0; r < residuals_.size(); ++r) {
    for (int k = 0; k < residuals_[r].count; ++k) {
      if (BlockOf(residuals_[r], k) != block) continue;
      return "block " + std::to_string(k) + size + " of residual " + std::to_string(r);
    }
  }
  return "a block without residuals" + size;
}

}  // namespace hpgo
