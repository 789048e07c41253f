// The graphs that the adapters are run on: public data sets and a city.
#pragma once

#include <time.h>

#include <cstdio>
#include <string>
#include <utility>
#include <variant>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/graph/compose_poses.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/replay.h"
#include "hpgo/solve/full_solve.h"
#include "test/optimizer/oracle.h"

namespace hpgo {

// "city N" or a file below the data folder; an empty graph where that is absent.
template <typename G>
PoseGraph<G> RealGraph(const std::string& name) {
  if (name.rfind("city ", 0) == 0) {
    GenerateOptions options;
    options.world = World::kCity;
    options.nodes = std::stoi(name.substr(5));
    return GenerateGraph<G>(options)->graph;
  }
  const std::string path = std::string(HPGO_SHARED_DATA_DIR) + "/" + name;
  Result<AnyGraphFile> file = ReadG2o(path, ReadOptions(), nullptr);
  if (!file.ok() && file.status().code() == StatusCode::kUnreadable) return {};
  EXPECT_TRUE(file.ok()) << file.status().ToString();
  PoseGraph<G> graph = std::get<GraphFile<G>>(*file).graph;
  ComposeMissingPoses(&graph);
  return graph;
}

// CPU time of this thread so far: other processes do not count.
inline double CpuMilliseconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

// What ceres::Solve takes for the graph, from its poses, on one thread.
template <typename G>
double CeresMilliseconds(PoseGraph<G> graph) {
  FullSolveOptions options;
  options.init = InitMethod::kFile;
  options.engine = Engine::kCeres;
  const double start = CpuMilliseconds();
  const FullSolveReport report = SolveFull(options, &graph);
  EXPECT_TRUE(report.status.ok()) << report.status.ToString();
  return CpuMilliseconds() - start;
}

}  // namespace hpgo
