// Full solves: the optimum that they reach.

#include "hpgo/solve/full_solve.h"

#include <cmath>
#include <string>

#include "full_solve_checks.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/solve/solver_factory.h"
#include "independent_solver.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

template <typename G>
void ForgetPoses(PoseGraph<G>* graph) {
  for (std::size_t k = 0; k < graph->nodes().size(); ++k) {
    graph->node(k).pose = G();
    graph->node(k).has_pose = false;
  }
}

// Appends the nodes and edges of `part`; ids must differ.
template <typename G>
void Append(const PoseGraph<G>& part, PoseGraph<G>* graph) {
  const int offset = static_cast<int>(graph->nodes().size());
  for (const GraphNode<G>& node : part.nodes()) ASSERT_TRUE(graph->AddNode(node).ok());
  for (GraphEdge<G> edge : part.edges()) {
    edge.i += offset;
    edge.j += offset;
    ASSERT_TRUE(graph->AddEdge(edge).ok());
  }
}

template <typename G>
class FullSolveTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FullSolveTest, Groups);

TYPED_TEST(FullSolveTest, ReachesTheOptimumFromEveryStart) {
  KnownGraph<TypeParam> known = MakeKnownGraph<TypeParam>(40, 0.05, 1);
  PoseGraph<TypeParam> at_truth = known.graph;
  for (int k = 0; k < 40; ++k) at_truth.node(k).pose = known.truth[k];
  const double optimum = IndependentSolver<TypeParam>(at_truth, 0).Solve();
  ASSERT_GT(optimum, 1e-3);

  for (const InitMethod init :
       {InitMethod::kFile, InitMethod::kOdometry, InitMethod::kSpanningTree, InitMethod::kChordal,
        InitMethod::kJointChordal, InitMethod::kAuto}) {
    SCOPED_TRACE(InitMethodName(init));
    PoseGraph<TypeParam> graph = known.graph;
    FullSolveOptions options;
    options.init = init;
    const FullSolveReport report = SolveFull(options, &graph);
    ASSERT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_TRUE(report.converged);
    EXPECT_NEAR(report.chi2_after, optimum, 1e-6 * optimum);
    PoseGraph<TypeParam> by_ceres = known.graph;
    options.engine = Engine::kCeres;
    EXPECT_NEAR(SolveFull(options, &by_ceres).chi2_after, optimum, 1e-6 * optimum);
    EXPECT_GT(report.chi2_before, 1.5 * optimum);
    EXPECT_EQ(report.cost_after, report.chi2_after);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.held_nodes, 1);
    EXPECT_EQ(report.loop_closures, 11);
    EXPECT_THAT(report.anchored, ElementsAre(0));
    EXPECT_LT(LargestDistance(graph, known.truth), 1);
    EXPECT_TRUE(SameBits(graph.nodes()[0].pose, known.graph.nodes()[0].pose));
  }
}

TYPED_TEST(FullSolveTest, MinimizesTheTwistErrorOnRequest) {
  const KnownGraph<TypeParam> known = MakeKnownGraph<TypeParam>(40, 0.2, 2);
  PoseGraph<TypeParam> g2o = known.graph, twist = known.graph;
  FullSolveOptions options;
  const FullSolveReport g2o_report = SolveFull(options, &g2o);
  options.convention = ceres_costs::ErrorConvention::kTwist;
  const FullSolveReport twist_report = SolveFull(options, &twist);
  EXPECT_TRUE(twist_report.converged);
  EXPECT_GT(std::abs(twist_report.chi2_after / g2o_report.chi2_after - 1), 1e-3);
  // In the other's convention each does worse than the other.
  options.init = InitMethod::kFile;
  options.max_iterations = 0;
  EXPECT_GT(SolveFull(options, &g2o).chi2_after, twist_report.chi2_after);
  options.convention = ceres_costs::ErrorConvention::kG2o;
  EXPECT_GT(SolveFull(options, &twist).chi2_after, g2o_report.chi2_after);
}

TYPED_TEST(FullSolveTest, SolvesEveryComponentAndKeepsTheFirstNodeOfEach) {
  PoseGraph<TypeParam> first = MakeKnownGraph<TypeParam>(20, 0.05, 3, 500).graph;
  PoseGraph<TypeParam> second = MakeKnownGraph<TypeParam>(25, 0.05, 4, 100).graph;
  PoseGraph<TypeParam> both = first;
  Append(second, &both);
  GraphNode<TypeParam> alone;
  alone.id = 7;
  alone.pose = TypeParam(both.nodes()[3].pose);
  ASSERT_TRUE(both.AddNode(alone).ok());
  const PoseGraph<TypeParam> before = both;

  const FullSolveReport report = SolveFull(FullSolveOptions(), &both);
  ASSERT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_EQ(report.components, 3);
  EXPECT_THAT(report.anchored, ElementsAre(500, 100, 7));
  const double sum = SolveFull(FullSolveOptions(), &first).chi2_after +
                     SolveFull(FullSolveOptions(), &second).chi2_after;
  EXPECT_NEAR(report.chi2_after, sum, 1e-7 * sum);
  for (const int held : {0, 20, 45}) {
    EXPECT_TRUE(SameBits(both.nodes()[held].pose, before.nodes()[held].pose)) << held;
  }
}

TYPED_TEST(FullSolveTest, FixedNodesNeverMoveByABit) {
  PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(30, 0.05, 5).graph;
  for (const int k : {4, 17, 18, 29}) graph.node(k).fixed = true;
  const PoseGraph<TypeParam> before = graph;
  for (const Engine engine : kEngines) {
    SCOPED_TRACE(EngineName(engine));
    graph = before;
    FullSolveOptions options;
    options.engine = engine;
    const FullSolveReport report = SolveFull(options, &graph);
    ASSERT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.held_nodes, 4);
    EXPECT_THAT(report.anchored, IsEmpty());
    EXPECT_LT(report.chi2_after, report.chi2_before);
    for (const int k : {4, 17, 18, 29}) {
      EXPECT_TRUE(SameBits(graph.nodes()[k].pose, before.nodes()[k].pose)) << k;
    }
    EXPECT_FALSE(SameBits(graph.nodes()[0].pose, before.nodes()[0].pose));
  }
}

TYPED_TEST(FullSolveTest, ComposesPosesWhereOnlyEdgesAreGiven) {
  PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(30, 0.05, 6).graph;
  PoseGraph<TypeParam> with_poses = graph;
  const double expected = SolveFull(FullSolveOptions(), &with_poses).chi2_after;
  ForgetPoses(&graph);
  const FullSolveReport report = SolveFull(FullSolveOptions(), &graph);
  ASSERT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_NEAR(report.chi2_after, expected, 1e-7 * expected);
  for (const GraphNode<TypeParam>& node : graph.nodes()) EXPECT_TRUE(node.has_pose);
  EXPECT_TRUE(SameBits(graph.nodes()[0].pose, TypeParam()));
  for (const InitCandidate& candidate : report.candidates) {
    EXPECT_NE(candidate.method, InitMethod::kFile);
  }
}

TYPED_TEST(FullSolveTest, PositionPriorsAnchorAGraphThatStartsFarOff) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(30, 0, 7);
  std::mt19937_64 rng(7);
  const G away = RandomPose<G>(&rng, 50, 2.5);
  for (int k = 0; k < 30; ++k) known.graph.node(k).pose = away * known.graph.nodes()[k].pose;
  for (const int k : {2, 11, 19, 28}) {
    GraphPrior<G> prior;
    prior.node = k;
    prior.offset = RandomPose<G>(&rng, 1, 1);
    prior.measurement.translation() =
        known.truth[k] * typename G::Vector(prior.offset.translation());
    prior.information.setZero();
    prior.information.template topLeftCorner<G::kDim, G::kDim>().setIdentity();
    ASSERT_TRUE(known.graph.AddPrior(prior).ok());
  }
  for (const Engine engine : kEngines) {
    for (const InitMethod init : {InitMethod::kAuto, InitMethod::kFile}) {
      SCOPED_TRACE(std::string(EngineName(engine)) + " " + InitMethodName(init));
      PoseGraph<G> graph = known.graph;
      FullSolveOptions options;
      options.engine = engine;
      options.init = init;
      const FullSolveReport report = SolveFull(options, &graph);
      ASSERT_TRUE(report.status.ok()) << report.status.ToString();
      EXPECT_EQ(report.held_nodes, 0);
      EXPECT_GT(report.chi2_before, 1);
      EXPECT_LT(report.chi2_after, 1e-9);
      EXPECT_LT(LargestDistance(graph, known.truth), 1e-4);
    }
  }
}

TYPED_TEST(FullSolveTest, DirectionsThatNothingMeasuresDoNotRunAway) {
  using G = TypeParam;
  PoseGraph<G> graph = MakeKnownGraph<G>(30, 0.05, 15).graph;
  PoseGraph<G> anchored = graph;
  const double optimum = SolveFull(FullSolveOptions(), &anchored).chi2_after;
  // One position: nothing tells the heading of the whole.
  GraphPrior<G> prior;
  prior.node = 12;
  prior.measurement.translation()(0) = 5;
  prior.information.setZero();
  prior.information.template topLeftCorner<G::kDim, G::kDim>().setIdentity();
  ASSERT_TRUE(graph.AddPrior(prior).ok());
  // A node hangs on an edge that measures no rotation.
  GraphNode<G> loose;
  loose.id = 1000;
  loose.pose = graph.nodes()[29].pose;
  ASSERT_TRUE(graph.AddNode(loose).ok());
  GraphEdge<G> edge;
  edge.i = 29;
  edge.j = 30;
  edge.measurement.translation()(1) = 2;
  edge.information.template bottomRightCorner<G::kRotationDof, G::kRotationDof>().setZero();
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  for (const Engine engine : kEngines) {
    for (const InitMethod init : {InitMethod::kFile, InitMethod::kChordal, InitMethod::kAuto}) {
      SCOPED_TRACE(std::string(EngineName(engine)) + " " + InitMethodName(init));
      PoseGraph<G> solved = graph;
      FullSolveOptions options;
      options.engine = engine;
      options.init = init;
      const FullSolveReport report = SolveFull(options, &solved);
      ASSERT_TRUE(report.status.ok()) << report.status.ToString();
      EXPECT_TRUE(report.converged);
      EXPECT_NEAR(report.chi2_after, optimum, 1e-6 * optimum);
      EXPECT_NEAR(solved.nodes()[12].pose.translation()(0), 5, 1e-4);
      for (const GraphNode<G>& node : solved.nodes()) {
        EXPECT_LT(node.pose.translation().norm(), 100);
      }
    }
  }
}

TYPED_TEST(FullSolveTest, AFullPriorIsWeighedAgainstTheEdges) {
  using G = TypeParam;
  PoseGraph<G> graph;
  for (const NodeId id : {1, 2}) {
    GraphNode<G> node;
    node.id = id;
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  GraphEdge<G> edge;
  edge.j = 1;
  edge.measurement.translation()(0) = 1;
  edge.information *= 3;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  for (const int node : {0, 1}) {
    GraphPrior<G> prior;
    prior.node = node;
    prior.measurement.translation()(0) = node == 0 ? 10 : 12;
    ASSERT_TRUE(graph.AddPrior(prior).ok());
  }
  // Along x: minimize (a - 10)^2 + (b - 12)^2 + 3 (b - a - 1)^2, so a = 10.6 - 3/14 and so on:
  // with s = b - a, (s - 2)^2 / 2 + 3 (s - 1)^2 is least at s = 8/7.
  const FullSolveReport report = SolveFull(FullSolveOptions(), &graph);
  ASSERT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_EQ(report.held_nodes, 0);
  EXPECT_NEAR(graph.nodes()[0].pose.translation()(0), 11 - 4.0 / 7, 1e-9);
  EXPECT_NEAR(graph.nodes()[1].pose.translation()(0), 11 + 4.0 / 7, 1e-9);
  EXPECT_NEAR(report.chi2_after, 3.0 / 7, 1e-9);
}

TYPED_TEST(FullSolveTest, EqualInputsGiveEqualBits) {
  PoseGraph<TypeParam> a = MakeKnownGraph<TypeParam>(50, 0.1, 12).graph, b = a;
  EXPECT_EQ(SolveFull(FullSolveOptions(), &a).chi2_after,
            SolveFull(FullSolveOptions(), &b).chi2_after);
  for (int k = 0; k < 50; ++k) EXPECT_TRUE(SameBits(a.nodes()[k].pose, b.nodes()[k].pose)) << k;
}

}  // namespace
}  // namespace hpgo
