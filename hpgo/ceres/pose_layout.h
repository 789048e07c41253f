// How a problem stores a pose in parameter blocks.
#pragma once

#include <string>
#include <vector>

namespace hpgo {

// One pose of a `ceres::Problem`: parameter blocks of these sizes, named in this order by the
// residuals over them. All poses of a problem have the same layout.
struct PoseLayout {
  enum class Kind {
    kUnknown,  // find out
    kXYTheta,  // plane
    kXYZQuaternion,
    kXYZYaw,  // gravity-aligned
  };
  enum class Direction { kUnknown, kWorldNode, kNodeWorld };  // T_world_node or its inverse
  enum class Quaternion { kUnknown, kWFirst, kWLast };        // w x y z, or x y z w as Eigen
  enum class AngleUnit { kUnknown, kRadians, kDegrees };

  // The sizes of its blocks, as {3, 4}, {4, 3}, {7}, {1, 1, 1}, {3}, {1, 3}, {3, 1} or {4}; empty:
  // find out.
  std::vector<int> sizes;
  Kind kind = Kind::kUnknown;
  Direction direction = Direction::kUnknown;
  Quaternion quaternion = Quaternion::kUnknown;
  AngleUnit angle = AngleUnit::kUnknown;
  // Where the translation and the quaternion or the angle begin in the blocks put one behind the
  // other; -1: find out.
  int translation_at = -1;
  int rotation_at = -1;
};

}  // namespace hpgo
