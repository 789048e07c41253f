// The parameter blocks of a problem that move, as parts of its poses.
#pragma once

#include <vector>

#include "ceres/manifold.h"
#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/problem_view.h"

namespace hpgo {

struct FreeBlock {
  int size = 0, tangent = 0;
  int offset = 0;  // of its values
  int step_at = 0;
  int jacobian_at = -1;  // of its PlusJacobian; -1: the identity
  const ceres::Manifold* manifold = nullptr;
};

// Values are those of all blocks, as ProblemView places them; steps and gradients hold `stride`
// numbers a pose that moves. Keeps its workspace: not synchronized.
class FreeBlocks {
 public:
  // Both arguments must outlive the object.
  FreeBlocks(const ProblemView& problem, const PoseBlocks& poses, int stride);

  // A block's place among those that move; -1: it is held.
  int PlaceOf(int block) const { return place_of_[block]; }
  // The number of a block's pose among those that move.
  int PoseOf(int block) const { return number_of_[poses_.pose_of[block]]; }
  const FreeBlock& operator[](int place) const { return blocks_[place]; }
  int num_poses() const { return num_poses_; }
  int num_blocks() const { return static_cast<int>(blocks_.size()); }
  int num_parameters() const { return Sum(&FreeBlock::size); }
  int num_dof() const { return Sum(&FreeBlock::tangent); }

  // What ToLocal goes by.
  void UpdatePlusJacobians(const std::vector<double>& values);
  // out (m rows, column-major with m rows a column) = J P, with J by the block's numbers,
  // row-major.
  void ToLocal(int m, int place, const double* J, double* out) const;

  // Ends a part of the step away from `values`; norms of what was moved and of what was there.
  // False if a manifold fails.
  struct Norms {
    double step = 0, value = 0;
  };
  [[nodiscard]] bool Move(const std::vector<double>& values, const std::vector<double>& step,
                          double part, std::vector<double>* moved, Norms* norms);
  // As Ceres does: by how far the blocks go along the negative gradient. False if not finite.
  struct GradientNorms {
    double norm = 0, max_norm = 0;
  };
  [[nodiscard]] bool Measure(const std::vector<double>& values, const std::vector<double>& gradient,
                             GradientNorms* norms);
  // Into the memory of the problem.
  void Write(const std::vector<double>& values) const;

 private:
  int Sum(int FreeBlock::*field) const;

  const ProblemView& problem_;
  const PoseBlocks& poses_;
  std::vector<FreeBlock> blocks_;
  std::vector<int> place_of_;
  std::vector<int> number_of_;  // by pose; -1: it is held
  int num_poses_ = 0;
  std::vector<double> plus_jacobians_, delta_, moved_;
};

}  // namespace hpgo
