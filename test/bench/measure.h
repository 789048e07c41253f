// What the benchmarks with a main of their own share.
#pragma once

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "hpgo/generate/synthetic_graph.h"

namespace hpgo {

// CPU time of all threads of the process so far.
inline double CpuSeconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The value that so large a share lies below; 0 of none.
inline double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto last = static_cast<double>(values.size() - 1);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * last);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// A 3D city of so many nodes as the first argument says, else 100,000. Prints why there is none.
inline std::optional<PoseGraph<SE3>> CityOfArguments(int argc, char** argv) {
  GenerateOptions options;
  options.world = World::kCity;
  options.nodes = argc > 1 ? std::atoi(argv[1]) : 100'000;
  Result<SyntheticGraph<SE3>> world = GenerateGraph<SE3>(options);
  if (world.ok()) return std::move(world->graph);
  std::fprintf(stderr, "%s\n", world.status().ToString().c_str());
  return std::nullopt;
}

}  // namespace hpgo
