// Clients that bring thousands of nodes between two updates, where dead reckoning has drifted by
// more than a linearization reaches. Chains that would have to bend that far, windows and rigid
// groups make knots of them.

#include <atomic>
#include <string>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/replay.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/update/news.h"
#include "test/optimizer/bring_all.h"

namespace hpgo {
namespace {

constexpr int kNodes = 12'000;

PoseGraph<SE3> DriftingCity(int nodes = kNodes, double noise = 0.02, std::uint64_t seed = 1) {
  GenerateOptions generate;
  generate.world = World::kCity;
  generate.nodes = nodes;
  generate.noise_rotation = noise;
  generate.seed = seed;
  return GenerateGraph<SE3>(generate)->graph;
}

TEST(FarOffTest, ThousandsOfNodesAtOnceAreTakenIn) {
  const PoseGraph<SE3> graph = DriftingCity();
  const double optimum = OptimumOf(graph, InitMethod::kAuto);
  for (const bool converge : {false, true}) {
    SCOPED_TRACE(converge ? "Converge" : "Update");
    Optimizer<SE3> optimizer;
    for (const ReplayStep& step : ReplaySteps(graph)) {
      ASSERT_TRUE(ApplyStep<SE3>(graph, step, nullptr, &optimizer).ok());
      const std::size_t nodes = optimizer.num_nodes();
      if (nodes != 500 && nodes != 5200 && nodes != 8600 && nodes != kNodes) continue;
      UpdateReport report = converge ? optimizer.Converge() : optimizer.Update();
      ASSERT_TRUE(report.status.ok());
    }
    EXPECT_LE(optimizer.Cost(), (converge ? 1.000001 : 1.02) * optimum);
    EXPECT_TRUE(optimizer.Refine().at_rest);
    EXPECT_LE(optimizer.Cost(), 1.000001 * optimum);
  }
}

// What closes loops among new nodes must not tear their trajectory.
TEST(FarOffTest, BatchesEndWhereFullOptimizationDoes) {
  for (const PoseGraph<SE3>& graph :
       {DriftingCity(6'000, 0.01, 1), DriftingCity(kNodes, 0.005, 2)}) {
    const auto nodes = static_cast<double>(graph.nodes().size());
    Optimizer<SE3> optimizer;
    for (const ReplayStep& step : ReplaySteps(graph)) {
      ASSERT_TRUE(ApplyStep<SE3>(graph, step, nullptr, &optimizer).ok());
      for (const double part : {1. / 24, 0.43, 0.72, 1.}) {
        if (optimizer.num_nodes() != static_cast<std::size_t>(part * nodes)) continue;
        EXPECT_TRUE(optimizer.Converge().at_rest);
      }
    }
    EXPECT_LE(optimizer.Cost(), 1.000001 * OptimumOf(graph, InitMethod::kOdometry));
  }
}

// All of them in slices that have no time: the end is that of a full optimization from the same
// start, dead reckoning, a minimum above the lowest.
TEST(FarOffTest, SlicesOfRefineEndWhereFullOptimizationDoes) {
  const PoseGraph<SE3> graph = DriftingCity();
  Optimizer<SE3> optimizer;
  BringAll(graph, &optimizer);
  UpdateLimits limits;
  limits.max_cpu_seconds = 1e-9;
  UpdateReport report;
  for (int slice = 0; slice < 1000 && !report.at_rest; ++slice) {
    report = optimizer.Refine(limits);
    ASSERT_TRUE(report.status.ok());
  }
  EXPECT_TRUE(report.at_rest);
  EXPECT_LE(optimizer.Cost(), 1.000001 * OptimumOf(graph, InitMethod::kOdometry));
}

// With all that a graph may have beside chains: a fixed node, a prior with a lever arm, a second
// component, losses, a removed edge.
template <typename G>
class FarOffGroupTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FarOffGroupTest, Groups);

template <typename G>
double LowestFrom(const Optimizer<G>& optimizer) {
  PoseGraph<G> graph = optimizer.ToGraph();
  FullSolveOptions options;
  options.init = InitMethod::kFile;
  EXPECT_TRUE(SolveFull(options, &graph).status.ok());
  Optimizer<G> there;
  EXPECT_TRUE(there.AddGraph(graph).ok());
  return there.Cost();
}

TYPED_TEST(FarOffGroupTest, TellsTheTruthOfAnyGraph) {
  using G = TypeParam;
  constexpr int kLoop = 300;
  for (const Engine engine : {Engine::kBlock, Engine::kCeres}) {
    SCOPED_TRACE(engine == Engine::kBlock ? "block" : "ceres");
    OptimizerOptions options;
    options.engine = engine;
    Optimizer<G> optimizer(options);
    const typename G::Matrix information = 100 * G::Matrix::Identity();
    typename G::Tangent step = G::Tangent::Zero();
    step(0) = 1;
    step(G::kDof - 1) = 2 * EIGEN_PI / kLoop;
    const G straight = G::Exp(step);
    // Two loops; the robot believes it turns half as fast again.
    typename G::Tangent bent = step;
    bent(G::kDof - 1) *= 1.5;
    for (int loop = 0; loop < 2; ++loop) {
      const int first = loop * 1000;
      G pose;
      for (int k = 0; k < kLoop; ++k) {
        ASSERT_TRUE(optimizer.AddNode(first + k, pose).ok());
        pose = pose * G::Exp(bent);
        if (k > 0) {
          ASSERT_TRUE(optimizer.AddEdge(first + k - 1, first + k, straight, information).ok());
        }
      }
      ASSERT_TRUE(optimizer.AddEdge(first + kLoop - 1, first, straight, information).ok());
      const auto across =
          optimizer.AddEdge(first + 20, first + 200, G(), typename G::Matrix(information));
      ASSERT_TRUE(across.ok());
      ASSERT_TRUE(optimizer.RemoveEdge(*across).ok());
    }
    ASSERT_TRUE(optimizer.SetFixed(0, true).ok());
    ASSERT_TRUE(optimizer.AddPrior(1000, straight, information, straight).ok());
    const double before = optimizer.Cost();
    const UpdateReport report = optimizer.Update();
    ASSERT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_NEAR(report.cost_decrease, before - optimizer.Cost(), 1e-5 * before);
    EXPECT_EQ(optimizer.FindInconsistency(), "");
    EXPECT_TRUE(optimizer.Refine().at_rest);
    if (engine == Engine::kBlock) {  // Ceres crosses no half turn
      EXPECT_LE(optimizer.Cost(), LowestFrom(optimizer) * (1 + 1e-6) + 1e-9);
    }
    const G fixed = *optimizer.GetPose(0);
    EXPECT_EQ(fixed.LocalCoordinates(G()).norm(), 0);
  }
}

TEST(FarOffTest, ConvergeKeepsAShortLimitAndGetsThereAllTheSame) {
  const PoseGraph<SE3> graph = DriftingCity();
  Optimizer<SE3> optimizer;
  BringAll(graph, &optimizer);
  UpdateLimits limits;
  limits.max_seconds = 0.01;
  const double before = optimizer.Cost();
  ASSERT_TRUE(optimizer.Converge(limits).status.ok());
  EXPECT_LT(optimizer.Cost(), before);
}

// What measures no rotation is not turned against it.
TEST(FarOffTest, PositionsAloneAreNotFarOff) {
  for (const double rotation : {0., 100.}) {
    Optimizer<SE2> optimizer;
    ASSERT_TRUE(optimizer.AddNode(0, SE2()).ok());
    ASSERT_TRUE(optimizer.AddNode(1, SE2(1, 0, 2)).ok());
    ASSERT_TRUE(optimizer.SetFixed(0, true).ok());
    ASSERT_TRUE(optimizer.SetFixed(1, true).ok());
    const SE2::Matrix information = SE2::Tangent(100, 100, rotation).asDiagonal();
    ASSERT_TRUE(optimizer.AddEdge(0, 1, SE2(1, 0, 0), information).ok());
    ASSERT_TRUE(optimizer.Update().status.ok());
    EXPECT_EQ(IsFarOff({0}, optimizer.hierarchy()), rotation > 0);
  }
}

TEST(FarOffTest, ACancelledConvergeLosesNothing) {
  Optimizer<SE2> optimizer;
  const SE2::Matrix information = 100 * SE2::Matrix::Identity();
  for (int k = 0; k < 30; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, SE2(k, 0.1 * k * k, 0)).ok());
    if (k > 0) {
      ASSERT_TRUE(optimizer.AddEdge(k - 1, k, SE2(1, 0, 0.2), information).ok());
    }
  }
  ASSERT_TRUE(optimizer.AddEdge(29, 0, SE2(1, 0, 0.3), information).ok());
  const std::atomic<bool> cancel{true};
  UpdateLimits limits;
  limits.cancel = &cancel;
  EXPECT_FALSE(optimizer.Converge(limits).at_rest);
  for (int k = 0; k < 20 && !optimizer.Update().at_rest; ++k) continue;
  const double rested = optimizer.Cost();
  EXPECT_TRUE(optimizer.Converge().at_rest);
  EXPECT_LE(rested, optimizer.Cost() * 1.03);
}

}  // namespace
}  // namespace hpgo
