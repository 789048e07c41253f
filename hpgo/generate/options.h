// What a synthetic world is made of.
#pragma once

#include <cstdint>
#include <string>

#include "hpgo/graph/status.h"

namespace hpgo {

enum class World {
  kSphere,      // a spiral from pole to pole, each turn seen from the next; 3D
  kTorus,       // a helix around the tube, likewise; 3D
  kGrid,        // a lattice swept row by row, layer by layer in 3D
  kManhattan,   // a random walk through a small street grid, in 3D on several floors with ramps
  kCity,        // a drive through long streets, revisited now and then; hills in 3D
  kTrajectory,  // a given trajectory (GenerateAlong)
};

// "sphere", "torus", ...; kInvalidArgument names the worlds there are.
Result<World> ParseWorld(const std::string& name);
const char* WorldName(World world);

struct GenerateOptions {
  World world = World::kManhattan;
  int nodes = 1000;        // > 0. One metre of way each, but for a given trajectory
  std::uint64_t seed = 1;  // the same options and seed give the same graph, bit for bit

  // Standard deviations of each measurement, per axis: m, rad. 0 gives exact measurements, weighted
  // as if it were kExactSigma.
  double noise_translation = 0.02;
  double noise_rotation = 0.005;
  static constexpr double kExactSigma = 0.01;

  // Loop closures per node; negative: the world's own (DefaultClosureDensity). Where the path does
  // not revisit enough places there are fewer.
  double closure_density = -1;
  // The share of the loop closures that are wrong: they name a place far from the one seen.
  double outliers = 0;  // in [0, 1]
  // Correlated noise: the information matrices are dense, a different one for every edge.
  bool dense_information = false;
};

// What makes `options` unusable in a space of `dim` dimensions (2 or 3), if anything.
Status CheckOptions(const GenerateOptions& options, int dim);

double DefaultClosureDensity(World world);

}  // namespace hpgo
