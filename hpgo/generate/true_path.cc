#include "hpgo/generate/true_path.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

constexpr double kAttitudeSigma = 0.01;  // rad of roll and of pitch

std::vector<Waypoint> Path(const GenerateOptions& options, int dim, Random* random) {
  switch (options.world) {
    case World::kSphere:
      return SpherePath(options.nodes);
    case World::kTorus:
      return TorusPath(options.nodes);
    case World::kGrid:
      return GridPath(options.nodes, dim);
    case World::kManhattan:
      return ManhattanPath(options.nodes, dim, random);
    case World::kCity:
      return CityPath(options.nodes, dim, random);
    case World::kTrajectory:
      break;
  }
  return {};
}

void MakePose(const Eigen::Vector3d& position, const Eigen::Vector3d& forward,
              const Eigen::Vector3d& /*up*/, Random* /*random*/, SE2* pose) {
  *pose = SE2(position.x(), position.y(), std::atan2(forward.y(), forward.x()));
}
void MakePose(const Eigen::Vector3d& position, const Eigen::Vector3d& forward,
              const Eigen::Vector3d& up, Random* random, SE3* pose) {
  Eigen::Matrix3d axes;
  axes.col(0) = forward;
  axes.col(1) = up.cross(forward).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  Eigen::Vector3d attitude = Eigen::Vector3d::Zero();
  attitude.x() = kAttitudeSigma * random->Normal();
  attitude.y() = kAttitudeSigma * random->Normal();
  *pose = SE3(position, (Eigen::Quaterniond(axes) * ceres_costs::So3Exp(attitude)).normalized());
}

}  // namespace

template <typename G>
std::vector<G> TruePoses(const GenerateOptions& options) {
  Random path_random(options.seed, 1), attitude_random(options.seed, 2);
  const std::vector<Waypoint> path = Path(options, G::kDim, &path_random);
  std::vector<G> poses(path.size());
  Eigen::Vector3d forward = Eigen::Vector3d::UnitX();
  for (std::size_t k = 0; k < path.size(); ++k) {
    const std::size_t before = k == 0 ? 0 : k - 1, after = std::min(k + 1, path.size() - 1);
    // A way that turns back on the spot has no direction: the last one is kept.
    const Eigen::Vector3d way = path[after].position - path[before].position;
    if (way.cross(path[k].up).norm() > 1e-3) forward = way.normalized();
    MakePose(path[k].position, forward, path[k].up, &attitude_random, &poses[k]);
  }
  const G T_first_world = poses.empty() ? G() : poses.front().Inverse();
  for (G& pose : poses) pose = (T_first_world * pose).Normalized();
  if (!poses.empty()) poses.front() = G();
  return poses;
}

template std::vector<SE2> TruePoses<SE2>(const GenerateOptions&);
template std::vector<SE3> TruePoses<SE3>(const GenerateOptions&);

}  // namespace hpgo
