// From world coordinates to a picture: a map in 2D, an oblique parallel view in 3D.
#pragma once

#include <vector>

#include "Eigen/Core"
#include "hpgo/report/plot_graph.h"

namespace hpgo {

// A parallel projection. Lengths along the picture's horizontal are true.
class PlotView {
 public:
  // The view of a graph. 2D: x to the right, y up. 3D: from 30 degrees above, the longer horizontal
  // direction turned towards the picture's horizontal. Up is z, or -y where the graph is flattest
  // along y (the camera frame of KITTI), or x where it is flattest along x.
  static PlotView Of(const PlotGraph& graph);

  // Metres; x to the right, y up.
  Eigen::Vector2d Project(const Eigen::Vector3d& p) const { return {right_.dot(p), up_.dot(p)}; }
  // Metres, larger is farther.
  double Depth(const Eigen::Vector3d& p) const { return away_.dot(p); }

 private:
  Eigen::Vector3d right_ = Eigen::Vector3d::UnitX();
  Eigen::Vector3d up_ = Eigen::Vector3d::UnitY();
  Eigen::Vector3d away_ = -Eigen::Vector3d::UnitZ();
};

// An axis-parallel box in the plane.
struct PlotBox {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();

  Eigen::Vector2d size() const { return high - low; }
  Eigen::Vector2d center() const { return 0.5 * (low + high); }
};

// The box around all projected positions; at least 1e-6 wide and high.
PlotBox ProjectedBox(const PlotGraph& graph, const PlotView& view);

}  // namespace hpgo
