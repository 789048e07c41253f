// Full solves with a robust loss.

#include <random>
#include <string>

#include "full_solve_checks.h"
#include "gtest/gtest.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/solver_factory.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class FullSolveLossesTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FullSolveLossesTest, Groups);

TYPED_TEST(FullSolveLossesTest, ARobustLossOnClosuresOvercomesOutliers) {
  using G = TypeParam;
  KnownGraph<G> known = MakeKnownGraph<G>(60, 0.01, 8);
  for (std::size_t k = 0; k < known.graph.edges().size(); ++k) {
    known.graph.edge(k).information = 1e4 * G::Matrix::Identity();
  }
  std::mt19937_64 rng(8);
  for (int k = 0; k < 6; ++k) {
    GraphEdge<G> wrong;
    wrong.i = 8 * k;
    wrong.j = 8 * k + 15;
    wrong.measurement = RandomPose<G>(&rng, 8, 2);
    wrong.information = 1e4 * G::Matrix::Identity();
    ASSERT_TRUE(known.graph.AddEdge(wrong).ok());
  }
  PoseGraph<G> plain = known.graph;
  EXPECT_TRUE(SolveFull(FullSolveOptions(), &plain).status.ok());
  EXPECT_GT(LargestDistance(plain, known.truth), 1);
  for (const Engine engine : kEngines) {
    for (const char* loss : {"cauchy", "geman_mcclure", "dcs", "tukey"}) {
      SCOPED_TRACE(std::string(EngineName(engine)) + " " + loss);
      PoseGraph<G> robust = known.graph;
      FullSolveOptions options;
      options.engine = engine;
      options.loss = loss;
      options.loss_scale = 5;
      const FullSolveReport report = SolveFull(options, &robust);
      ASSERT_TRUE(report.status.ok()) << report.status.ToString();
      EXPECT_LT(LargestDistance(robust, known.truth), 0.15);
      EXPECT_LT(report.cost_after, report.chi2_after);
      EXPECT_LE(report.cost_after, report.cost_start);
    }
  }
}

TYPED_TEST(FullSolveLossesTest, TheScopeOfTheLossDecidesAboutOdometry) {
  // Two nodes, one odometry edge off by 10 from a prior-like fixed pair: only "all" softens it.
  using G = TypeParam;
  PoseGraph<G> graph;
  for (const NodeId id : {1, 2}) {
    GraphNode<G> node;
    node.id = id;
    node.fixed = true;
    ASSERT_TRUE(graph.AddNode(node).ok());
  }
  GraphEdge<G> edge;
  edge.j = 1;
  edge.measurement.translation()(0) = 10;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  FullSolveOptions options;
  options.loss = "huber";
  FullSolveReport report = SolveFull(options, &graph);
  EXPECT_TRUE(report.converged);
  EXPECT_NEAR(report.cost_after, 100, 1e-9);
  options.loss_on = LossScope::kAllEdges;
  report = SolveFull(options, &graph);
  EXPECT_NEAR(report.cost_after, 19, 1e-9);  // 2 * 10 - 1
  EXPECT_NEAR(report.chi2_after, 100, 1e-9);
}

}  // namespace
}  // namespace hpgo
