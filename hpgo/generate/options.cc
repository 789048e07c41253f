#include "hpgo/generate/options.h"

#include <cmath>
#include <iterator>

namespace hpgo {
namespace {

struct NamedWorld {
  World world;
  const char* name;
  double closure_density;
};
constexpr NamedWorld kWorlds[] = {
    {World::kSphere, "sphere", 1.0}, {World::kTorus, "torus", 0.8},
    {World::kGrid, "grid", 1.4},     {World::kManhattan, "manhattan", 0.75},
    {World::kCity, "city", 0.04},    {World::kTrajectory, "trajectory", 0.04},
};

const NamedWorld& Entry(World world) {
  for (const NamedWorld& entry : kWorlds) {
    if (entry.world == world) return entry;
  }
  return kWorlds[0];
}

Status Invalid(const std::string& message) { return Status(StatusCode::kInvalidArgument, message); }

}  // namespace

Result<World> ParseWorld(const std::string& name) {
  std::string known;
  for (const NamedWorld& entry : kWorlds) {
    if (name == entry.name) return entry.world;
    known += (known.empty() ? "" : ", ") + std::string(entry.name);
  }
  return Invalid("no world \"" + name + "\"; there are " + known);
}

const char* WorldName(World world) { return Entry(world).name; }
double DefaultClosureDensity(World world) { return Entry(world).closure_density; }

Status CheckOptions(const GenerateOptions& options, int dim) {
  if (dim == 2 && (options.world == World::kSphere || options.world == World::kTorus)) {
    return Invalid(std::string("the ") + WorldName(options.world) + " is a 3D world");
  }
  if (options.nodes < 1) return Invalid("nodes: " + std::to_string(options.nodes) + " is below 1");
  const auto is_sigma = [](double sigma) { return std::isfinite(sigma) && sigma >= 0; };
  if (!is_sigma(options.noise_translation)) {
    return Invalid("translation noise: not a finite number >= 0");
  }
  if (!is_sigma(options.noise_rotation)) return Invalid("rotation noise: not a finite number >= 0");
  if (!std::isfinite(options.closure_density)) return Invalid("closure density: not finite");
  if (!(options.outliers >= 0 && options.outliers <= 1)) {
    return Invalid("outliers: not a share between 0 and 1");
  }
  return Status::Ok();
}

}  // namespace hpgo
