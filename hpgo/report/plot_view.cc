#include "hpgo/report/plot_view.h"

#include <cmath>

#include "Eigen/Geometry"
#include "ceres_costs/symmetric_eigen.h"

namespace hpgo {
namespace {

constexpr double kElevation = 30 * M_PI / 180;
// Between the longer horizontal direction and the picture's horizontal: seen exactly from the side,
// a box looks flat.
constexpr double kTurn = 25 * M_PI / 180;
// An axis is "up" if the graph is flatter than this along it, against the next flattest.
constexpr double kFlat = 0.4;

// The unit vector that points up in the world of these positions with the given covariance.
Eigen::Vector3d UpOf(const Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d spread = covariance.diagonal().cwiseSqrt();
  int flattest = 2;
  for (int axis = 0; axis < 2; ++axis) {
    const double others = std::min(spread[2], spread[1 - axis]);
    if (spread[axis] < kFlat * others) flattest = axis;
  }
  if (flattest == 1) return -Eigen::Vector3d::UnitY();
  return Eigen::Vector3d::Unit(flattest);
}

Eigen::Matrix3d Covariance(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p;
  mean /= std::max<double>(1, static_cast<double>(points.size()));
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) sum += (p - mean) * (p - mean).transpose();
  return sum;
}

}  // namespace

PlotView PlotView::Of(const PlotGraph& graph) {
  PlotView view;
  if (!graph.is_3d) return view;
  const Eigen::Matrix3d covariance = Covariance(graph.positions);
  const Eigen::Vector3d up = UpOf(covariance);
  const Eigen::Vector3d side = up.unitOrthogonal();
  Eigen::Matrix<double, 3, 2> ground;
  ground << side, up.cross(side);
  const auto axes = ceres_costs::EigenOf<2>(ground.transpose() * covariance * ground);
  Eigen::Vector2d main = axes.vectors.col(1);
  // Equally wide both ways (a sphere, a grid): the axes say nothing, so keep to the world's.
  if (axes.values[1] < 1.5 * axes.values[0]) main = Eigen::Vector2d::UnitX();
  // An eigenvector's sign is arbitrary; make it repeatable.
  if (main.x() < 0 || (main.x() == 0 && main.y() < 0)) main = -main;
  const Eigen::Vector3d right = Eigen::AngleAxisd(kTurn, up) * (ground * main);
  const Eigen::Vector3d forward = up.cross(right);
  view.right_ = right;
  view.away_ = std::cos(kElevation) * forward - std::sin(kElevation) * up;
  view.up_ = std::sin(kElevation) * forward + std::cos(kElevation) * up;
  return view;
}

PlotBox ProjectedBox(const PlotGraph& graph, const PlotView& view) {
  constexpr double kMinExtent = 1e-6;
  PlotBox box;
  for (std::size_t k = 0; k < graph.positions.size(); ++k) {
    const Eigen::Vector2d p = view.Project(graph.positions[k]);
    box.low = k == 0 ? p : Eigen::Vector2d(box.low.cwiseMin(p));
    box.high = k == 0 ? p : Eigen::Vector2d(box.high.cwiseMax(p));
  }
  for (int axis = 0; axis < 2; ++axis) {
    const double missing = kMinExtent - box.size()[axis];
    if (missing > 0) {
      box.low[axis] -= missing / 2;
      box.high[axis] += missing / 2;
    }
  }
  return box;
}

}  // namespace hpgo
