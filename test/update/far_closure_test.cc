// A loop closure in a dense world that is far off: what it bends is smooth and runs over the whole
// map, so that windows would need hundreds of updates for the last percents.

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <variant>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/state_file.h"
#include "hpgo/replay.h"
#include "hpgo/update/constants.h"
#include "test/optimizer/oracle.h"

namespace hpgo {
namespace {

constexpr int kNodes = 3000;
constexpr int kMostOfWindows = 1700;  // nodes solved in an update, the top's among them

PoseGraph<SE3> Manhattan() {
  GenerateOptions generate;
  generate.world = World::kManhattan;
  generate.nodes = kNodes;
  return GenerateGraph<SE3>(generate)->graph;
}

// The first `steps` nodes, at their optimum.
template <typename G>
void Bring(const PoseGraph<G>& graph, std::size_t steps, Optimizer<G>* optimizer) {
  const std::vector<ReplayStep> all = ReplaySteps(graph);
  for (std::size_t k = 0; k < steps; ++k) {
    ASSERT_TRUE(ApplyStep<G>(graph, all[k], nullptr, optimizer).ok());
  }
  ASSERT_TRUE(optimizer->Converge().at_rest);
}

// `means`: chi2 of the closure.
template <typename G>
void CloseFarOff(const PoseGraph<G>& graph, double means, Optimizer<G>* optimizer) {
  const auto& nodes = graph.nodes();
  const NodeId i = nodes[nodes.size() / 20].id, j = nodes[optimizer->num_nodes() - 1].id;
  const typename G::Matrix information = graph.edges().front().information;
  const double mean = optimizer->Cost() / static_cast<double>(optimizer->num_edges());
  typename G::Tangent offset = G::Tangent::Zero();
  offset(0) = std::sqrt(means * mean / information(0, 0));
  const G there = optimizer->GetPose(i)->Between(*optimizer->GetPose(j)).Retract(offset);
  ASSERT_TRUE(optimizer->AddEdge(i, j, there, information).ok());
}

// Windows alone are 0.9 % above it then, with twice as many an update.
TEST(FarClosureTest, TwentyUpdatesEndAtTheOptimum) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  int first_of_all = 0;  // update that moved all nodes
  for (int k = 1; k <= 20; ++k) {
    const UpdateReport report = optimizer.Update();
    ASSERT_TRUE(report.status.ok());
    if (first_of_all == 0 && report.solved_nodes > kMostOfWindows) first_of_all = k;
  }
  EXPECT_LT(Gap(optimizer), 0.0003);
  // Those that gained much, one that begins, and one to factor.
  EXPECT_GT(first_of_all, kUpdatesFarOff + 2);
}

// The robot drives on meanwhile: what is new follows the steps.
TEST(FarClosureTest, NodesThatComeMeanwhileAreTakenAlong) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes - 20, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  const std::vector<ReplayStep> steps = ReplaySteps(graph);
  for (std::size_t k = kNodes - 20; k < kNodes; ++k) {
    ASSERT_TRUE(ApplyStep<SE3>(graph, steps[k], nullptr, &optimizer).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  EXPECT_EQ(optimizer.FindInconsistency(), "");
  EXPECT_LT(Gap(optimizer), 0.01);  // 0.07 where they stay behind
}

TEST(FarClosureTest, ACancelledUpdateDoesNoSlice) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  for (int k = 0; k < kUpdatesFarOff; ++k) ASSERT_TRUE(optimizer.Update().status.ok());
  const std::atomic<bool> cancel{true};
  UpdateLimits limits;
  limits.cancel = &cancel;
  for (int k = 0; k < 20; ++k) EXPECT_EQ(optimizer.Update(limits).solved_nodes, 0);
  EXPECT_LT(optimizer.Update().solved_nodes, kMostOfWindows);  // it has still to begin
}

// Refine has done what the next steps would have.
TEST(FarClosureTest, RefineGivesItUp) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  int updates = 0;
  while (optimizer.Update().solved_nodes <= kMostOfWindows) ASSERT_LT(++updates, 20);
  ASSERT_TRUE(optimizer.Refine().at_rest);
  EXPECT_EQ(optimizer.Update().solved_nodes, 0);
}

// What such a step leaves, or does not know of, windows still look at: a closure between
// neighbours, of which no level above knows.
TEST(FarClosureTest, ClosuresThatComeMeanwhileAreTakenIn) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  for (int k = 0; k < 14; ++k) {
    const NodeId i = graph.nodes()[500 + 100 * k].id, j = graph.nodes()[501 + 100 * k].id;
    SE3::Tangent offset = SE3::Tangent::Zero();
    offset(1) = 1;
    const SE3 there = optimizer.GetPose(i)->Between(*optimizer.GetPose(j)).Retract(offset);
    ASSERT_TRUE(optimizer.AddEdge(i, j, there, graph.edges().front().information).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(optimizer.Update().status.ok());
  EXPECT_LT(Gap(optimizer), 1e-4);
}

// Nodes that go, and others that are held from then on.
TEST(FarClosureTest, NodesThatGoMeanwhileAreLeftOut) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  for (int k = 0; k < 20; ++k) {
    if (k > 3 && k < 8) {
      ASSERT_TRUE(optimizer.RemoveNode(graph.nodes()[1000 + k].id).ok());
      ASSERT_TRUE(optimizer.SetFixed(graph.nodes()[1500 + k].id, true).ok());
    }
    ASSERT_TRUE(optimizer.Update().status.ok());
  }
  EXPECT_EQ(optimizer.FindInconsistency(), "");
  EXPECT_LT(Gap(optimizer), 0.001);
}

// Ordinary closures are none: hardly an update of a replay moves all.
TEST(FarClosureTest, OrdinaryClosuresAreLeftToWindows) {
  const Result<AnyGraphFile> file =
      ReadG2o(std::string(HPGO_SHARED_DATA_DIR) + "/g2o/sphere2500.g2o", ReadOptions(), nullptr);
  if (!file.ok()) GTEST_SKIP() << file.status().ToString();
  const PoseGraph<SE3>& graph = std::get<GraphFile<SE3>>(*file).graph;
  Optimizer<SE3> optimizer;
  int moved_all = 0;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<SE3>(graph, step, nullptr, &optimizer).ok());
    const UpdateReport report = optimizer.Update();
    ASSERT_TRUE(report.status.ok());
    moved_all += report.solved_nodes > kMostOfWindows;
  }
  EXPECT_LE(moved_all, 5);
}

// A level that would take too long to order in one update is left to windows, too.
TEST(FarClosureTest, LargeLevelsAreLeftToWindows) {
  GenerateOptions generate;
  generate.world = World::kManhattan;
  generate.nodes = 45'000;
  const PoseGraph<SE2> graph = GenerateGraph<SE2>(generate)->graph;
  Optimizer<SE2> optimizer;
  Bring(graph, 45'000, &optimizer);
  CloseFarOff(graph, 1e6, &optimizer);
  for (int k = 0; k < 25; ++k) {
    const UpdateReport report = optimizer.Update();
    ASSERT_TRUE(report.status.ok());
    EXPECT_LT(report.solved_nodes, kMostOfWindows) << k;
  }
}

// Saved after any of the updates, the next ones do the same; a part of the file is refused.
TEST(FarClosureTest, ASavedStateGoesOnWithTheSameBits) {
  const PoseGraph<SE3> graph = Manhattan();
  Optimizer<SE3> optimizer;
  Bring(graph, kNodes, &optimizer);
  CloseFarOff(graph, 1e5, &optimizer);
  const std::string path =
      testing::TempDir() + "hpgo_far_closure_" + std::to_string(getpid()) + ".state";
  Optimizer<SE3> loaded;
  for (int k = 0; k < 14; ++k) {
    ASSERT_TRUE(SaveState(optimizer, path).ok());
    ASSERT_TRUE(LoadState(path, &loaded).ok());
    std::ifstream in(path, std::ios::binary);
    const std::string bytes(std::istreambuf_iterator<char>(in), {});
    for (std::size_t size = 1000; size < bytes.size(); size += 900'000) {
      ASSERT_EQ(ParseState(std::string_view(bytes).substr(0, size), &loaded).code(),
                StatusCode::kMalformed);
    }
    const UpdateReport expected = optimizer.Update(), report = loaded.Update();
    EXPECT_EQ(report.solved_nodes, expected.solved_nodes) << k;
    EXPECT_EQ(loaded.Cost(), optimizer.Cost()) << k;
  }
  unlink(path.c_str());
}

}  // namespace
}  // namespace hpgo
