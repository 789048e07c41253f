// Which minimum a full solve ends in.
#include <algorithm>
#include <cmath>
#include <string>

#include "gtest/gtest.h"
#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/solver_factory.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
PoseGraph<G> Noisy(World world, double rotation, int seed) {
  GenerateOptions options;
  options.world = world;
  options.nodes = 60;
  options.seed = seed;
  options.noise_translation = 0.1;
  options.noise_rotation = rotation;
  return GenerateGraph<G>(options)->graph;
}

template <typename G>
FullSolveReport Solve(PoseGraph<G> graph, InitMethod init, Engine engine = Engine::kBlock) {
  FullSolveOptions options;
  options.init = init;
  options.engine = engine;
  return SolveFull(options, &graph);
}

TEST(FullSolveStartsTest, AutoEndsAtTheLowestOfManyStarts) {
  int chordal_higher = 0;
  for (int seed = 1; seed <= 3; ++seed) {
    const PoseGraph3d graph = Noisy<SE3>(World::kGrid, 0.8, seed);
    const FullSolveReport report = Solve(graph, InitMethod::kAuto);
    ASSERT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_TRUE(report.converged);
    EXPECT_GE(report.runs, 3);
    for (const InitCandidate& candidate : report.candidates) {
      if (!candidate.solved) continue;
      EXPECT_GE(candidate.end_cost, report.cost_after * (1 - 1e-5) - 1e-6);
    }
    for (const InitMethod init :
         {InitMethod::kFile, InitMethod::kSpanningTree, InitMethod::kChordal}) {
      const double end = Solve(graph, init).cost_after;
      EXPECT_LE(report.cost_after, end * (1 + 1e-4)) << seed << " " << InitMethodName(init);
      chordal_higher += init == InitMethod::kChordal && end > report.cost_after * (1 + 1e-3);
    }
    if (seed > 1) continue;
    const double by_ceres = Solve(graph, InitMethod::kAuto, Engine::kCeres).cost_after;
    EXPECT_NEAR(by_ceres, report.cost_after, 1e-4 * by_ceres) << seed;
  }
  EXPECT_GE(chordal_higher, 1);
}

TEST(FullSolveStartsTest, ThreeEqualEndsAreEnough) {
  const PoseGraph2d graph = Noisy<SE2>(World::kManhattan, 0.01, 1);
  const FullSolveReport report = Solve(graph, InitMethod::kAuto);
  EXPECT_EQ(report.runs, 3);
  int solved = 0, iterations = 0;
  for (const InitCandidate& candidate : report.candidates) {
    solved += candidate.solved;
    iterations += candidate.iterations;
  }
  EXPECT_EQ(solved, 3);
  EXPECT_EQ(iterations, report.iterations);
}

TEST(FullSolveStartsTest, AStartByNameIsTheOnlyOne) {
  const FullSolveReport report =
      Solve(Noisy<SE2>(World::kManhattan, 0.8, 1), InitMethod::kJointChordal);
  EXPECT_EQ(report.runs, 1);
  EXPECT_EQ(report.init, InitMethod::kJointChordal);
  EXPECT_EQ(report.candidates.size(), 1);
}

// A square walked twice with a heading that drifts: at the start every closure of the second round
// is far off, though right.
template <typename G>
KnownGraph<G> DriftingSquare() {
  KnownGraph<G> known;
  const auto turn = [](double angle) {
    typename G::Tangent d = G::Tangent::Zero();
    d(0) = 1;
    G step = G().Retract(d);
    d.setZero();
    d(G::kDof - 1) = angle;
    return step * G().Retract(d);
  };
  constexpr int kSide = 10, kNodes = 8 * kSide;
  std::vector<GraphEdge<G>> edges;
  for (int k = 0; k < kNodes; ++k) {
    GraphNode<G> node;
    node.id = k;
    const double corner = k % kSide == 0 && k > 0 ? M_PI / 2 : 0;
    known.truth.push_back(k == 0 ? G() : known.truth.back() * turn(corner));
    if (k > 0) {
      GraphEdge<G> edge;
      edge.i = k - 1;
      edge.j = k;
      edge.measurement = turn(corner + 0.02);
      edge.information = 1e3 * G::Matrix::Identity();
      edges.push_back(edge);
      node.pose = known.graph.nodes().back().pose * edge.measurement;
    }
    (void)known.graph.AddNode(node);
  }
  for (int k = kNodes / 2; k < kNodes; k += 4) {
    GraphEdge<G> edge;
    edge.i = k;
    edge.j = k - kNodes / 2;
    edge.measurement = known.truth[edge.i].Between(known.truth[edge.j]);
    edge.information = 1e3 * G::Matrix::Identity();
    edges.push_back(edge);
  }
  // Two that are wrong.
  for (const int k : {45, 70}) {
    GraphEdge<G> edge;
    edge.i = k;
    edge.j = k - 30;
    edge.information = 1e3 * G::Matrix::Identity();
    edges.push_back(edge);
  }
  for (const GraphEdge<G>& edge : edges) (void)known.graph.AddEdge(edge);
  return known;
}

template <typename G>
class RedescendingTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(RedescendingTest, Groups);

TYPED_TEST(RedescendingTest, KeepsRightClosuresThatAreFarOffAtTheStart) {
  const KnownGraph<TypeParam> known = DriftingSquare<TypeParam>();
  for (const Engine engine : {Engine::kCeres, Engine::kBlock}) {
    for (const char* loss : {"dcs", "tukey", "geman_mcclure"}) {
      for (const InitMethod init : {InitMethod::kFile, InitMethod::kAuto}) {
        SCOPED_TRACE(std::string(EngineName(engine)) + " " + loss + " " + InitMethodName(init));
        PoseGraph<TypeParam> graph = known.graph;
        FullSolveOptions options;
        options.engine = engine;
        options.init = init;
        options.loss = loss;
        options.loss_scale = std::string(loss) == "dcs" ? 9 : 3;
        const FullSolveReport report = SolveFull(options, &graph);
        ASSERT_TRUE(report.status.ok()) << report.status.ToString();
        EXPECT_TRUE(report.converged);
        EXPECT_LE(report.cost_after, report.cost_start);
        // The closures of the second round hold: ends of a right one are where they should be.
        for (std::size_t k = 79; k + 2 < graph.edges().size(); ++k) {
          const GraphEdge<TypeParam>& edge = graph.edges()[k];
          const TypeParam T = graph.nodes()[edge.i].pose.Between(graph.nodes()[edge.j].pose);
          EXPECT_LT(edge.measurement.LocalCoordinates(T).norm(), 0.3) << k;
        }
      }
    }
  }
}

}  // namespace
}  // namespace hpgo
