// What can be read of a ceres::Problem, in arrays.
#pragma once

#include <string>
#include <vector>

#include "ceres/problem.h"

namespace hpgo {

struct BlockView {
  double* values = nullptr;
  int size = 0;
  int tangent = 0;
  int offset = 0;  // of its values among those of all blocks
  bool constant = false;
  bool bounded = false;
  bool used = false;                          // by a residual
  const ceres::Manifold* manifold = nullptr;  // null: Euclidean
};

struct ResidualView {
  ceres::ResidualBlockId id = nullptr;
  const ceres::CostFunction* cost = nullptr;
  const ceres::LossFunction* loss = nullptr;
  int first = 0, count = 0;  // of its blocks, in ProblemView::indices
};

[[nodiscard]] bool IsBounded(const ceres::Problem& problem, const double* values, int size);

// A copy of the structure; the problem is not changed. Borrows costs, losses and manifolds. Blocks
// and residuals in the order of the problem.
class ProblemView {
 public:
  explicit ProblemView(const ceres::Problem& problem);

  const std::vector<BlockView>& blocks() const { return blocks_; }
  const std::vector<ResidualView>& residuals() const { return residuals_; }
  // The block at place k of a residual.
  int BlockOf(const ResidualView& residual, int k) const { return indices_[residual.first + k]; }
  // For messages: "block 1 (size 3) of residual 20", the first residual over it. O(residuals).
  std::string NameOf(int block) const;
  int num_values() const { return num_values_; }
  int num_residuals() const { return num_residuals_; }

 private:
  std::vector<BlockView> blocks_;
  std::vector<ResidualView> residuals_;
  std::vector<int> indices_;
  int num_values_ = 0, num_residuals_ = 0;
};

}  // namespace hpgo
