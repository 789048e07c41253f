// Paths that cover a surface or a volume once, turn beside turn.
#include <algorithm>
#include <cmath>

#include "hpgo/generate/true_path.h"

namespace hpgo {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kStep = 1.0;   // m between nodes
constexpr double kPitch = 1.0;  // m between turns

}  // namespace

// A spiral of constant pitch: 2 pi R / pitch turns a radian of polar angle, so that the area
// 4 pi R^2 is covered by `nodes` steps.
std::vector<Waypoint> SpherePath(int nodes) {
  const double radius = std::sqrt(nodes * kStep * kPitch / (4 * kPi));
  const double turns = 2 * kPi * radius / kPitch;  // azimuth per polar angle
  const auto rate = [&](double polar) {            // of the polar angle along the way
    const double s = turns * std::sin(polar);
    return kStep / (radius * std::sqrt(1 + s * s));
  };
  std::vector<Waypoint> path;
  path.reserve(nodes);
  double polar = 0;
  for (int k = 0; k < nodes; ++k) {
    const double azimuth = turns * polar;
    const Eigen::Vector3d up(std::sin(polar) * std::cos(azimuth),
                             std::sin(polar) * std::sin(azimuth), std::cos(polar));
    path.push_back({radius * up, up});
    polar = std::min(kPi, polar + rate(polar + 0.5 * rate(polar)));
  }
  return path;
}

// A helix of constant pitch around the tube of a torus with radii 3 r and r: area 12 pi^2 r^2.
std::vector<Waypoint> TorusPath(int nodes) {
  const double tube = std::sqrt(nodes * kStep * kPitch / (12 * kPi * kPi));
  const double ring = 3 * tube;
  const double advance = kPitch / (2 * kPi * ring);  // angle around the ring per angle of the tube
  std::vector<Waypoint> path;
  path.reserve(nodes);
  double v = 0;
  for (int k = 0; k < nodes; ++k) {
    const double u = advance * v;
    const Eigen::Vector3d out(std::cos(u), std::sin(u), 0);
    const Eigen::Vector3d up = std::cos(v) * out + std::sin(v) * Eigen::Vector3d::UnitZ();
    path.push_back({ring * out + tube * up, up});
    const double along_ring = (ring + tube * std::cos(v)) * advance;
    v += kStep / std::sqrt(tube * tube + along_ring * along_ring);
  }
  return path;
}

// Row by row, each back to front of the one before; layer by layer likewise.
std::vector<Waypoint> GridPath(int nodes, int dim) {
  const double side = dim == 3 ? std::cbrt(nodes) : std::sqrt(nodes);
  const int n = std::max(1, static_cast<int>(std::ceil(side - 1e-9)));
  std::vector<Waypoint> path;
  path.reserve(nodes);
  for (int k = 0; k < nodes; ++k) {
    const int row = k / n, layer = dim == 3 ? row / n : 0;
    const int row_in_layer = row - layer * n;
    const int x = row % 2 == 0 ? k % n : n - 1 - k % n;
    const int y = layer % 2 == 0 ? row_in_layer : n - 1 - row_in_layer;
    path.push_back({kStep * Eigen::Vector3d(x, y, layer), Eigen::Vector3d::UnitZ()});
  }
  return path;
}

}  // namespace hpgo
