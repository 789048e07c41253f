// Optimizers on threads of their own share nothing.
//
// HPGO_THREADS_NODES=20000 makes the graphs larger; meant for ThreadSanitizer, which
// tools/check --sanitize runs on the default.

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/optimizer.h"

namespace hpgo {
namespace {

// Many closures: the factor is so dense that METIS orders the full solve.
template <typename G>
PoseGraph<G> DenseWorld(int nodes, std::uint64_t seed) {
  GenerateOptions options;
  options.world = G::kDim == 2 ? World::kGrid : World::kSphere;
  options.nodes = nodes;
  options.seed = seed;
  options.noise_translation = 0.01;
  options.noise_rotation = 0.0005;
  options.closure_density = 3;
  return GenerateGraph<G>(options)->graph;
}

// What the calls on one optimizer give, bit for bit.
struct Outcome {
  std::string error;
  std::vector<double> values;
};

template <typename G>
void Work(int nodes, std::uint64_t seed, Engine engine, Outcome* outcome) {
  OptimizerOptions options;
  options.engine = engine;
  Optimizer<G> optimizer(options);
  const auto expect = [&](const Status& status, const char* what) {
    if (!status.ok() && outcome->error.empty()) outcome->error = what + (": " + status.ToString());
  };
  const PoseGraph<G> graph = DenseWorld<G>(nodes, seed);
  expect(optimizer.AddGraph(graph), "AddGraph");
  expect(optimizer.Optimize(Mode::kFull).status, "kFull");
  const G moved =
      *optimizer.GetPose(nodes / 2) * graph.edges()[0].measurement * graph.edges()[0].measurement;
  expect(optimizer.SetPose(nodes / 2, moved), "SetPose");
  expect(optimizer.Update().status, "Update");
  const UpdateReport refined = optimizer.Refine();
  expect(refined.status, "Refine");
  const Result<typename G::Matrix> covariance = optimizer.MarginalCovariance(nodes - 1);
  expect(covariance.status(), "MarginalCovariance");
  outcome->values = {optimizer.Cost(), refined.at_rest ? 1. : 0.,
                     covariance.ok() ? covariance->trace() : -1};
  optimizer.ForEachPose([&](NodeId, const G& pose) {
    outcome->values.insert(outcome->values.end(), pose.data(), pose.data() + G::kParams);
  });
}

TEST(ThreadsTest, OptimizersOnFourThreadsDoAsEachAlone) {
  const char* given = std::getenv("HPGO_THREADS_NODES");
  const int nodes = given != nullptr ? std::atoi(given) : 1200;
  using Task = void (*)(int, std::uint64_t, Engine, Outcome*);
  const Task tasks[4] = {Work<SE2>, Work<SE3>, Work<SE2>, Work<SE3>};
  const auto engine = [](int k) { return k < 2 ? Engine::kBlock : Engine::kCeres; };
  Outcome together[4];
  std::vector<std::thread> threads;
  for (int k = 0; k < 4; ++k) threads.emplace_back(tasks[k], nodes, 7, engine(k), &together[k]);
  for (std::thread& thread : threads) thread.join();
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ(together[k].error, "");
    ASSERT_GT(together[k].values.size(), 3u);
    EXPECT_EQ(together[k].values[1], 1) << "not at rest";
    if (given != nullptr) continue;  // once is long enough
    Outcome alone;
    tasks[k](nodes, 7, engine(k), &alone);
    EXPECT_EQ(together[k].values, alone.values) << "task " << k;
  }
}

}  // namespace
}  // namespace hpgo
