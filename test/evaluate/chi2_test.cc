#include "hpgo/evaluate/chi2.h"

#include <cmath>
#include <limits>

#include "ceres/loss_function.h"
#include "gtest/gtest.h"
#include "test/evaluate/random_poses.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;

template <typename G>
PoseGraph<G> Chain(const std::vector<G>& poses) {
  PoseGraph<G> graph;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    GraphNode<G> node;
    node.id = static_cast<NodeId>(k);
    node.pose = poses[k];
    EXPECT_TRUE(graph.AddNode(node).ok());
  }
  return graph;
}

TEST(Chi2Test, KnownValueIn2d) {
  PoseGraph2d graph = Chain<SE2>({SE2(), SE2(1.5, 0.25, 0.5)});
  GraphEdge<SE2> edge;
  edge.j = 1;
  edge.measurement = SE2(1, 0, 0);
  edge.information << 4, 1, 0, 1, 2, 0, 0, 0, 8;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  // e = (0.5, 0.25, 0.5): 4/4 + 2/16 + 2/8 + 8/4.
  const Chi2Report report = EvaluateChi2(graph);
  EXPECT_DOUBLE_EQ(report.total, 1 + 0.125 + 0.25 + 2);
  EXPECT_DOUBLE_EQ(report.edges[0], report.total);
  EXPECT_DOUBLE_EQ(report.robust_total, report.total);
}

TEST(Chi2Test, ConventionsIn3dDifferInTheRotation) {
  const Eigen::Quaterniond half_turn(Eigen::AngleAxisd(M_PI / 3, Eigen::Vector3d::UnitZ()));
  PoseGraph3d graph =
      Chain<SE3>({SE3(), SE3(Eigen::Vector3d::Zero(), Eigen::Quaterniond(-half_turn.coeffs()))});
  GraphEdge<SE3> edge;
  edge.j = 1;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  Chi2Options options;
  EXPECT_NEAR(EvaluateChi2(graph, options).total, 0.25, 1e-15) << "sin^2 of 30 degrees";
  options.convention = ErrorConvention::kTwist;
  EXPECT_NEAR(EvaluateChi2(graph, options).total, M_PI * M_PI / 9, 1e-14);
  options.convention = ErrorConvention::kSplitLog;
  EXPECT_NEAR(EvaluateChi2(graph, options).total, M_PI * M_PI / 9, 1e-14);
}

TEST(Chi2Test, DenseInformationAndPriorsAgreeWithTheFormula) {
  std::mt19937_64 rng(3);
  PoseGraph3d graph = Chain(RandomPoses<SE3>(&rng, 5));
  double edges = 0, priors = 0;
  for (int k = 0; k < 4; ++k) {
    GraphEdge<SE3> edge;
    edge.i = k + 1;
    edge.j = k;
    edge.measurement = RandomPose<SE3>(&rng);
    edge.information = RandomInformation<SE3>(&rng);
    ASSERT_TRUE(graph.AddEdge(edge).ok());
    GraphPrior<SE3> prior;
    prior.node = k;
    prior.measurement = RandomPose<SE3>(&rng);
    prior.offset = RandomPose<SE3>(&rng);
    prior.information = RandomInformation<SE3>(&rng);
    ASSERT_TRUE(graph.AddPrior(prior).ok());
    const auto term = [](const SE3& D, const SE3::Matrix& information) {
      SE3::Tangent e;
      e << D.translation(), (D.rotation().w() < 0 ? -1 : 1) * D.rotation().vec();
      return (e.transpose() * information * e).value();
    };
    const std::vector<GraphNode<SE3>>& nodes = graph.nodes();
    edges += term(edge.measurement.Inverse() * nodes[k + 1].pose.Inverse() * nodes[k].pose,
                  edge.information);
    priors += term(prior.measurement.Inverse() * nodes[k].pose * prior.offset, prior.information);
  }
  const Chi2Report report = EvaluateChi2(graph);
  EXPECT_NEAR(report.edge_total, edges, 1e-10 * edges);
  EXPECT_NEAR(report.prior_total, priors, 1e-10 * priors);
  EXPECT_DOUBLE_EQ(report.total, report.edge_total + report.prior_total);
  EXPECT_EQ(report.edges.size(), 4u);
  EXPECT_EQ(report.priors.size(), 4u);
}

TEST(Chi2Test, TheLossAppliesToLoopClosuresUnlessAskedOtherwise) {
  PoseGraph2d graph = Chain<SE2>({SE2(), SE2(10, 0, 0), SE2(20, 0, 0)});
  for (int j : {1, 2}) {  // both off by 10 m: chi2 100
    GraphEdge<SE2> edge;
    edge.j = j;
    edge.measurement = SE2(10.0 * j - 10, 0, 0);
    ASSERT_TRUE(graph.AddEdge(edge).ok());
  }
  const ceres::HuberLoss huber(1.0);  // rho(100) = 2 * 10 - 1
  Chi2Options options;
  options.loss = &huber;
  EXPECT_DOUBLE_EQ(EvaluateChi2(graph, options).robust_total, 100 + 19);
  EXPECT_DOUBLE_EQ(EvaluateChi2(graph, options).total, 200);
  options.loss_on_closures_only = false;
  EXPECT_DOUBLE_EQ(EvaluateChi2(graph, options).robust_total, 19 + 19);
}

TEST(Chi2Test, ANonFinitePoseIsNotHidden) {
  PoseGraph2d graph = Chain<SE2>({SE2(), SE2(NAN, 0, 0)});
  GraphEdge<SE2> edge;
  edge.j = 1;
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  EXPECT_TRUE(std::isnan(EvaluateChi2(graph).total));
}

TEST(WorstEdgesTest, LargestFirstAndNaNBeforeThem) {
  const std::vector<double> chi2 = {1, 5, NAN, 5, 0};
  const std::vector<WorstEdge> worst = WorstEdges(chi2, 3);
  ASSERT_EQ(worst.size(), 3u);
  EXPECT_EQ(worst[0].edge, 2);
  EXPECT_EQ(worst[1].edge, 1);
  EXPECT_EQ(worst[2].edge, 3);
  EXPECT_EQ(worst[2].chi2, 5);
  EXPECT_EQ(WorstEdges(chi2, 99).size(), 5u);
  EXPECT_TRUE(WorstEdges(chi2, -1).empty());
}

}  // namespace
}  // namespace hpgo
