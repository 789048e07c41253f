#include "hpgo/generate/synthetic_graph.h"

#include <cmath>
#include <cstring>
#include <limits>

#include "Eigen/Eigenvalues"
#include "gtest/gtest.h"
#include "hpgo/evaluate/chi2.h"
#include "hpgo/graph/edge_classes.h"

namespace hpgo {
namespace {

template <typename G>
SyntheticGraph<G> Generate(const GenerateOptions& options) {
  auto generated = GenerateGraph<G>(options);
  EXPECT_TRUE(generated.ok()) << generated.status().ToString();
  return generated.ok() ? *generated : SyntheticGraph<G>();
}

GenerateOptions Options(World world, int nodes, std::uint64_t seed = 1) {
  GenerateOptions options;
  options.world = world;
  options.nodes = nodes;
  options.seed = seed;
  return options;
}

template <typename G>
double Chi2AtTruth(const SyntheticGraph<G>& synthetic) {
  PoseGraph<G> graph = synthetic.graph;
  for (std::size_t k = 0; k < synthetic.truth.size(); ++k) graph.node(k).pose = synthetic.truth[k];
  return EvaluateChi2(graph).total;
}

template <typename G>
bool SameBits(const SyntheticGraph<G>& a, const SyntheticGraph<G>& b) {
  if (a.graph.nodes().size() != b.graph.nodes().size()) return false;
  if (a.graph.edges().size() != b.graph.edges().size()) return false;
  const auto same = [](const double* x, const double* y, int count) {
    return std::memcmp(x, y, sizeof(double) * count) == 0;
  };
  for (std::size_t k = 0; k < a.truth.size(); ++k) {
    if (!same(a.truth[k].data(), b.truth[k].data(), G::kParams)) return false;
    if (!same(a.graph.nodes()[k].pose.data(), b.graph.nodes()[k].pose.data(), G::kParams)) {
      return false;
    }
  }
  for (std::size_t k = 0; k < a.graph.edges().size(); ++k) {
    const GraphEdge<G>&e = a.graph.edges()[k], &f = b.graph.edges()[k];
    if (e.i != f.i || e.j != f.j || !same(e.measurement.data(), f.measurement.data(), G::kParams) ||
        !same(e.information.data(), f.information.data(), G::kDof * G::kDof)) {
      return false;
    }
  }
  return true;
}

template <typename G>
void ExpectRobotLike(const SyntheticGraph<G>& synthetic) {
  const PoseGraph<G>& graph = synthetic.graph;
  ASSERT_EQ(graph.nodes().size(), synthetic.truth.size());
  EXPECT_EQ((G().LocalCoordinates(synthetic.truth[0])).norm(), 0);
  EXPECT_EQ((G().LocalCoordinates(graph.nodes()[0].pose)).norm(), 0);
  for (std::size_t k = 0; k < graph.nodes().size(); ++k) {
    ASSERT_EQ(graph.nodes()[k].id, static_cast<NodeId>(k));
    if (k == 0) continue;
    const double step =
        (synthetic.truth[k].translation() - synthetic.truth[k - 1].translation()).norm();
    ASSERT_GT(step, 0.3) << "node " << k;
    ASSERT_LT(step, 2.0) << "node " << k;
  }
  const std::vector<bool> closure = LoopClosures(graph);
  int newest = 0, closures = 0;
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    const GraphEdge<G>& edge = graph.edges()[k];
    if (closure[k]) {
      ++closures;
      ASSERT_EQ(edge.i, newest) << "closures arrive with the node that sees them";
      ASSERT_LT(edge.j, edge.i);
    } else {
      ASSERT_EQ(edge.i, newest);
      ASSERT_EQ(edge.j, newest + 1);
      newest = edge.j;
    }
  }
  EXPECT_EQ(closures, synthetic.closures);
  EXPECT_EQ(newest + 1, static_cast<int>(graph.nodes().size()));
}

struct Case {
  World world;
  int dim;
  double low, high;  // edges a node at 5000 nodes
};

class WorldTest : public ::testing::TestWithParam<Case> {
 protected:
  template <typename G>
  void Check() {
    const Case c = GetParam();
    for (std::uint64_t seed : {1, 2, 3}) {
      const auto graph = Generate<G>(Options(c.world, 5000, seed));
      ExpectRobotLike(graph);
      const double edges = static_cast<double>(graph.graph.edges().size());
      EXPECT_GE(edges / 5000, c.low) << "seed " << seed;
      EXPECT_LE(edges / 5000, c.high) << "seed " << seed;
      // chi2 over its degrees of freedom: mean 1, standard deviation sqrt(2 / (edges dof)).
      EXPECT_NEAR(Chi2AtTruth(graph) / (edges * G::kDof), 1, 6 * std::sqrt(2 / (edges * G::kDof)));
      EXPECT_GT(EvaluateChi2(graph.graph).total, Chi2AtTruth(graph));
    }
  }
  template <typename G>
  void CheckExact() {
    GenerateOptions options = Options(GetParam().world, 2000);
    options.noise_translation = options.noise_rotation = 0;
    const auto graph = Generate<G>(options);
    EXPECT_GT(graph.closures, 20);
    EXPECT_LT(Chi2AtTruth(graph), 1e-12);
    EXPECT_LT(EvaluateChi2(graph.graph).total, 1e-12) << "exact odometry, exact dead reckoning";
  }
  template <typename G>
  void CheckSeeds() {
    GenerateOptions options = Options(GetParam().world, 1500, 7);
    options.dense_information = true;
    options.outliers = 0.1;
    const auto first = Generate<G>(options);
    EXPECT_TRUE(SameBits(first, Generate<G>(options)));
    options.seed = 8;
    EXPECT_FALSE(SameBits(first, Generate<G>(options)));
  }
};

TEST_P(WorldTest, LooksLikeARobotsGraph) { GetParam().dim == 2 ? Check<SE2>() : Check<SE3>(); }
TEST_P(WorldTest, WithoutNoiseTheTruthIsExact) {
  GetParam().dim == 2 ? CheckExact<SE2>() : CheckExact<SE3>();
}
TEST_P(WorldTest, TheSeedDecidesEveryBit) {
  GetParam().dim == 2 ? CheckSeeds<SE2>() : CheckSeeds<SE3>();
}

INSTANTIATE_TEST_SUITE_P(
    Worlds, WorldTest,
    ::testing::Values(Case{World::kSphere, 3, 1.95, 2.0}, Case{World::kTorus, 3, 1.75, 1.85},
                      Case{World::kGrid, 3, 2.35, 2.45}, Case{World::kGrid, 2, 1.9, 2.0},
                      Case{World::kManhattan, 3, 1.72, 1.78},
                      Case{World::kManhattan, 2, 1.72, 1.78}, Case{World::kCity, 3, 1.03, 1.05},
                      Case{World::kCity, 2, 1.03, 1.05}),
    [](const auto& instance) {
      return WorldName(instance.param.world) + std::to_string(instance.param.dim) + "d";
    });

TEST(GenerateGraphTest, ManhattanHasFloors) {
  const auto graph = Generate<SE3>(Options(World::kManhattan, 20000));
  std::vector<int> nodes(5, 0);
  for (const SE3& pose : graph.truth) {
    const double floor = pose.translation().z() / 2.5;
    if (std::abs(floor - std::round(floor)) > 0.1) continue;  // on a ramp
    ASSERT_GE(std::lround(floor), 0);
    ASSERT_LT(std::lround(floor), 5);
    ++nodes[std::lround(floor)];
  }
  for (int floor = 0; floor < 5; ++floor) EXPECT_GT(nodes[floor], 500) << "floor " << floor;
}

TEST(GenerateGraphTest, ClosuresArriveAllTheTime) {
  for (World world : {World::kManhattan, World::kCity}) {
    const auto graph = Generate<SE3>(Options(world, 20000));
    std::vector<int> closures(4, 0);
    for (const auto& edge : graph.graph.edges()) closures[edge.i / 5000] += edge.j < edge.i;
    for (int quarter = 0; quarter < 4; ++quarter) {
      EXPECT_GT(closures[quarter], 0.15 * graph.closures) << WorldName(world) << ' ' << quarter;
    }
  }
}

TEST(GenerateGraphTest, DensityIsHeldOrAllRevisitsAreTaken) {
  GenerateOptions options = Options(World::kManhattan, 5000);
  options.closure_density = 0;
  EXPECT_EQ(Generate<SE2>(options).closures, 0);
  options.closure_density = 0.3;
  EXPECT_NEAR(Generate<SE2>(options).closures, 1500, 100);
  options.closure_density = 1e12;
  const int all = Generate<SE2>(options).closures;
  EXPECT_GT(all, 5000);
  EXPECT_LT(all, 5000 * 60);
}

TEST(GenerateGraphTest, OutliersAreExactlyTheShareAndWrong) {
  GenerateOptions options = Options(World::kManhattan, 5000);
  options.outliers = 0.1;
  const auto graph = Generate<SE3>(options);
  ASSERT_EQ(static_cast<double>(graph.outlier_edges.size()), std::round(0.1 * graph.closures));
  const PoseGraph3d at_truth = TruthGraph(graph);
  const std::vector<bool> closure = LoopClosures(graph.graph);
  for (int k : graph.outlier_edges) {
    EXPECT_TRUE(closure[k]);
    const auto& edge = graph.graph.edges()[k];
    EXPECT_GT(EdgeChi2(at_truth, edge, ceres_costs::ErrorConvention::kG2o), 1000) << "edge " << k;
  }
  options.outliers = 0;
  EXPECT_EQ(Generate<SE3>(options).closures, graph.closures) << "outliers replace, they do not add";
}

TEST(GenerateGraphTest, DenseInformationWeighsItsOwnNoise) {
  for (double angle_sigma : {0.005, 0.03}) {
    GenerateOptions options = Options(World::kGrid, 3000);
    options.noise_rotation = angle_sigma;
    options.dense_information = true;
    const auto graph = Generate<SE3>(options);
    const double edges = static_cast<double>(graph.graph.edges().size());
    EXPECT_NEAR(Chi2AtTruth(graph) / (6 * edges), 1, 0.05);
    const SE3::Matrix& information = graph.graph.edges()[5].information;
    EXPECT_GT(std::abs(information(0, 4)), 1e-3) << "translation and rotation are correlated";
    EXPECT_EQ(information, information.transpose());
    EXPECT_GT(information.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
    EXPECT_NE(information, graph.graph.edges()[6].information);
  }
}

TEST(GenerateGraphTest, NoiseDoesNotMoveThePath) {
  GenerateOptions options = Options(World::kCity, 500);
  const auto quiet = Generate<SE2>(options);
  options.noise_translation = 0.5;
  const auto loud = Generate<SE2>(options);
  for (int k = 0; k < 500; ++k) {
    ASSERT_EQ(quiet.truth[k].LocalCoordinates(loud.truth[k]).norm(), 0) << k;
  }
}

TEST(GenerateGraphTest, TinyWorldsAreGraphsToo) {
  for (World world :
       {World::kSphere, World::kTorus, World::kGrid, World::kManhattan, World::kCity}) {
    for (int nodes : {1, 2, 3, 10}) {
      const auto graph = Generate<SE3>(Options(world, nodes));
      ASSERT_EQ(graph.truth.size(), static_cast<std::size_t>(nodes));
      EXPECT_GE(graph.graph.edges().size(), static_cast<std::size_t>(nodes - 1));
      EXPECT_TRUE(std::isfinite(Chi2AtTruth(graph))) << WorldName(world) << ' ' << nodes;
    }
  }
}

TEST(GenerateAlongTest, FollowsTheTrajectoryFromItsFirstPose) {
  // Twice around a circle of 50 m radius, in a frame far from the origin.
  std::vector<SE2> circle;
  const SE2 frame(1000, -500, 2);
  for (int k = 0; k < 630; ++k) {
    const double angle = k / 50.0;
    circle.push_back(frame * SE2(50 * std::sin(angle), 50 - 50 * std::cos(angle), angle));
  }
  GenerateOptions options;
  options.closure_density = 0.2;
  const auto along = GenerateAlong(circle, options);
  ASSERT_TRUE(along.ok()) << along.status().ToString();
  ExpectRobotLike(*along);
  EXPECT_GT(along->closures, 60);
  for (const auto& edge : along->graph.edges()) EXPECT_TRUE(edge.j > edge.i || edge.i > 300);
  for (int k = 0; k < 630; ++k) {
    ASSERT_LT(circle[0].Between(circle[k]).LocalCoordinates(along->truth[k]).norm(), 1e-9);
  }
}

TEST(GenerateErrorsTest, NameWhatIsWrong) {
  const auto error = [](const GenerateOptions& options) {
    return GenerateGraph<SE2>(options).status().ToString();
  };
  GenerateOptions options = Options(World::kSphere, 10);
  EXPECT_EQ(error(options), "invalid argument: the sphere is a 3D world");
  options.world = World::kTrajectory;
  EXPECT_EQ(error(options), "invalid argument: the trajectory world needs a trajectory");
  options.world = World::kGrid;
  options.nodes = 0;
  EXPECT_EQ(error(options), "invalid argument: nodes: 0 is below 1");
  options.nodes = 10;
  options.noise_translation = NAN;
  EXPECT_EQ(error(options), "invalid argument: translation noise: not a finite number >= 0");
  options.noise_translation = 0;
  options.noise_rotation = -1;
  EXPECT_EQ(error(options), "invalid argument: rotation noise: not a finite number >= 0");
  options.noise_rotation = 0;
  options.outliers = 1.5;
  EXPECT_EQ(error(options), "invalid argument: outliers: not a share between 0 and 1");
  options.outliers = 0;
  options.closure_density = INFINITY;
  EXPECT_EQ(error(options), "invalid argument: closure density: not finite");

  EXPECT_EQ(GenerateAlong(std::vector<SE2>(), GenerateOptions()).status().ToString(),
            "invalid argument: the trajectory has no poses");
  EXPECT_EQ(GenerateAlong<SE2>({SE2(), SE2(NAN, 0, 0)}, GenerateOptions()).status().ToString(),
            "invalid argument: pose 1 of the trajectory is not finite");
  EXPECT_EQ(ParseWorld("moon").status().ToString(),
            "invalid argument: no world \"moon\"; there are sphere, torus, grid, manhattan, city, "
            "trajectory");
  EXPECT_EQ(*ParseWorld("city"), World::kCity);
}

}  // namespace
}  // namespace hpgo
