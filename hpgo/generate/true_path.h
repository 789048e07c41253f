// The way a robot drives through a world, before anything is measured.
#pragma once

#include <vector>

#include "Eigen/Core"
#include "hpgo/generate/options.h"
#include "hpgo/generate/random.h"

namespace hpgo {

struct Waypoint {
  Eigen::Vector3d position;  // m
  Eigen::Vector3d up;        // unit
};

// The paths of the worlds, `nodes` waypoints about a metre apart.
std::vector<Waypoint> SpherePath(int nodes);
std::vector<Waypoint> TorusPath(int nodes);
std::vector<Waypoint> GridPath(int nodes, int dim);
std::vector<Waypoint> ManhattanPath(int nodes, int dim, Random* random);
std::vector<Waypoint> CityPath(int nodes, int dim, Random* random);

// The true poses along a world's path, the first at the identity. The robot looks where it drives
// (x forward, z up); in 3D it pitches and rolls a little. Requires CheckOptions, and a world that
// has a path of its own.
template <typename G>
std::vector<G> TruePoses(const GenerateOptions& options);

}  // namespace hpgo
