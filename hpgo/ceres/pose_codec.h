// Between a group's poses and the numbers a problem keeps of them.
#pragma once

#include "Eigen/Core"
#include "hpgo/ceres/pose_layout.h"

namespace hpgo {

// A pose's blocks put one behind the other, as a declared or recognized PoseLayout says they are to
// be read; `layout` must be complete. G is the group of its kind.
template <typename G>
class PoseCodec {
 public:
  // The derivative of the numbers by a right perturbation of the pose.
  using Jacobian = Eigen::Matrix<double, G::kParams, G::kDof>;

  explicit PoseCodec(const PoseLayout& layout) : layout_(layout) {}

  // T_world_node of the numbers.
  G Read(const double* values) const;
  // The numbers of a pose, an angle and the sign of a quaternion as near as can be to those there.
  void Write(const G& pose, double* values) const;
  // At the pose; `values` decide on the sign of a quaternion.
  Jacobian WriteJacobian(const G& pose, const double* values) const;

  const PoseLayout& layout() const { return layout_; }

 private:
  PoseLayout layout_;
};

}  // namespace hpgo
