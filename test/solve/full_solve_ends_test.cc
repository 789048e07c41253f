// Full solves: cancellation, limits, nothing to move, and what cannot be used.

#include <atomic>
#include <limits>
#include <string>

#include "full_solve_checks.h"
#include "gtest/gtest.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/solver_factory.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class FullSolveEndsTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FullSolveEndsTest, Groups);

TYPED_TEST(FullSolveEndsTest, CancelledBeforeItBeginsNothingChanges) {
  PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(30, 0.05, 9).graph;
  const PoseGraph<TypeParam> before = graph;
  const std::atomic<bool> cancel(true);
  FullSolveOptions options;
  options.cancel = &cancel;
  const FullSolveReport report = SolveFull(options, &graph);
  EXPECT_EQ(report.status.code(), StatusCode::kInterrupted);
  for (int k = 0; k < 30; ++k) {
    EXPECT_TRUE(SameBits(graph.nodes()[k].pose, before.nodes()[k].pose));
  }
}

TYPED_TEST(FullSolveEndsTest, CancelledOnTheWayTheBestSoFarIsKept) {
  for (const Engine engine : kEngines) {
    SCOPED_TRACE(EngineName(engine));
    PoseGraph<TypeParam> graph = MakeKnownGraph<TypeParam>(30, 0.05, 10).graph;
    std::atomic<bool> cancel(false);
    FullSolveOptions options;
    options.engine = engine;
    options.init = InitMethod::kFile;
    options.cancel = &cancel;
    double last_cost = -1;
    options.progress = [&](int iteration, double cost) {
      EXPECT_EQ(iteration, 1);
      last_cost = cost;
      cancel = true;
    };
    const FullSolveReport report = SolveFull(options, &graph);
    EXPECT_EQ(report.status.code(), StatusCode::kInterrupted);
    EXPECT_EQ(report.iterations, 1);
    EXPECT_LT(report.cost_after, report.cost_before);
    EXPECT_NEAR(report.cost_after, last_cost, 1e-9 * last_cost);
    FullSolveOptions evaluate;
    evaluate.max_iterations = 0;
    evaluate.init = InitMethod::kFile;
    EXPECT_NEAR(SolveFull(evaluate, &graph).chi2_before, report.chi2_after,
                1e-12 * report.chi2_after);
  }
}

TYPED_TEST(FullSolveEndsTest, ALimitLeavesAUsableResult) {
  const PoseGraph<TypeParam> input = MakeKnownGraph<TypeParam>(30, 0.05, 11).graph;
  for (const Engine engine : kEngines) {
    SCOPED_TRACE(EngineName(engine));
    FullSolveOptions options;
    options.engine = engine;
    options.init = InitMethod::kFile;
    options.max_seconds = 0;
    PoseGraph<TypeParam> graph = input;
    FullSolveReport report = SolveFull(options, &graph);
    EXPECT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, 0);

    options = FullSolveOptions();
    options.engine = engine;
    options.init = InitMethod::kFile;
    options.max_iterations = 1;
    graph = input;
    report = SolveFull(options, &graph);
    EXPECT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_FALSE(report.converged);
    EXPECT_EQ(report.iterations, 1);
    EXPECT_LT(report.chi2_after, report.chi2_before);
  }
}

TYPED_TEST(FullSolveEndsTest, GraphsWithNothingToMove) {
  PoseGraph<TypeParam> empty;
  FullSolveReport report = SolveFull(FullSolveOptions(), &empty);
  EXPECT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.components, 0);
  EXPECT_EQ(report.chi2_after, 0);

  PoseGraph<TypeParam> one;
  GraphNode<TypeParam> node;
  node.has_pose = false;
  ASSERT_TRUE(one.AddNode(node).ok());
  report = SolveFull(FullSolveOptions(), &one);
  EXPECT_TRUE(report.status.ok()) << report.status.ToString();
  EXPECT_TRUE(one.nodes()[0].has_pose);
  EXPECT_TRUE(SameBits(one.nodes()[0].pose, TypeParam()));
}

TYPED_TEST(FullSolveEndsTest, UnusableValuesAreNamedAndNothingChanges) {
  const PoseGraph<TypeParam> good = MakeKnownGraph<TypeParam>(5, 0.05, 13, 100).graph;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto message = [](PoseGraph<TypeParam> graph) {
    const PoseGraph<TypeParam> before = graph;
    const FullSolveReport report = SolveFull(FullSolveOptions(), &graph);
    EXPECT_EQ(report.status.code(), StatusCode::kInvalidArgument);
    for (std::size_t k = 0; k < before.nodes().size(); ++k) {
      EXPECT_TRUE(SameBits(graph.nodes()[k].pose, before.nodes()[k].pose)) << k;
    }
    return report.status.message();
  };
  PoseGraph<TypeParam> graph = good;
  graph.node(2).pose.translation()(1) = nan;
  EXPECT_EQ(message(graph), "node 102: the pose is not finite");
  graph = good;
  graph.edge(1).measurement.translation()(0) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(message(graph), "edge 101 -> 102: the measurement is not finite");
  graph = good;
  graph.edge(3).information(1, 1) = nan;
  EXPECT_EQ(message(graph), "edge 103 -> 104: information is not finite");
  graph = good;
  graph.edge(0).information(0, 1) += 1;
  EXPECT_EQ(message(graph), "edge 100 -> 101: information is not symmetric");
  graph = good;
  graph.edge(0).information = TypeParam::Matrix::Identity();
  graph.edge(0).information(0, 0) = -2;
  EXPECT_EQ(message(graph),
            "edge 100 -> 101: information is not positive semi-definite, smallest eigenvalue -2");
  graph = good;
  GraphPrior<TypeParam> prior;
  prior.node = 4;
  prior.offset.translation()(0) = nan;
  ASSERT_TRUE(graph.AddPrior(prior).ok());
  EXPECT_EQ(message(graph), "prior of node 104: the offset is not finite");
}

TEST(FullSolveOptionsTest, UnusableOptionsAreNamed) {
  PoseGraph2d graph;
  FullSolveOptions options;
  options.loss = "soft";
  FullSolveReport report = SolveFull(options, &graph);
  EXPECT_EQ(report.status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(report.status.message(),
            "unknown loss \"soft\"; known: none, huber, cauchy, tukey, geman_mcclure (gm), dcs");
  options = FullSolveOptions();
  options.max_iterations = -1;
  EXPECT_EQ(SolveFull(options, &graph).status.message(),
            "max_iterations is -1, must not be negative");
  options = FullSolveOptions();
  options.max_seconds = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(SolveFull(options, &graph).status.message(),
            "max_seconds is nan, must not be negative");
}

TEST(FullSolveSe3Test, AZeroQuaternionIsNamed) {
  PoseGraph3d graph = MakeKnownGraph<SE3>(4, 0.05, 14).graph;
  graph.node(3).pose.rotation().coeffs().setZero();
  EXPECT_EQ(SolveFull(FullSolveOptions(), &graph).status.message(),
            "node 3: the pose has a zero quaternion");
}

}  // namespace
}  // namespace hpgo
