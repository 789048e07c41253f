#include "hpgo/solve/undetermined.h"

#include <memory>
#include <random>
#include <string>

#include "ceres_costs/losses.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/solver_factory.h"
#include "small_graphs.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

template <typename G>
typename G::Matrix NoRotation() {
  typename G::Matrix information = G::Matrix::Identity();
  information.template bottomRightCorner<G::kRotationDof, G::kRotationDof>().setZero();
  return information;
}

// A node at the end of an edge with this information and length 2 along y.
template <typename G>
void Hang(int from, NodeId id, const typename G::Matrix& information, PoseGraph<G>* graph) {
  GraphNode<G> node;
  node.id = id;
  node.pose = graph->nodes()[from].pose;
  ASSERT_TRUE(graph->AddNode(node).ok());
  GraphEdge<G> edge;
  edge.i = from;
  edge.j = static_cast<int>(graph->nodes().size()) - 1;
  edge.measurement.translation()(1) = 2;
  edge.information = information;
  ASSERT_TRUE(graph->AddEdge(edge).ok());
}

template <typename G>
class UndeterminedTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(UndeterminedTest, Groups);

TYPED_TEST(UndeterminedTest, NodesThatHangOnSemiDefiniteEdgesAreNamed) {
  using G = TypeParam;
  for (const Engine engine : {Engine::kBlock, Engine::kCeres}) {
    SCOPED_TRACE(EngineName(engine));
    const auto undetermined = [engine](PoseGraph<G> graph) {
      FullSolveOptions options;
      options.engine = engine;
      const FullSolveReport report = SolveFull(options, &graph);
      EXPECT_TRUE(report.status.ok()) << report.status.ToString();
      return report.undetermined;
    };
    PoseGraph<G> graph = MakeKnownGraph<G>(30, 0.05, 15).graph;
    EXPECT_THAT(undetermined(graph), IsEmpty());
    Hang<G>(3, 1000, NoRotation<G>(), &graph);
    EXPECT_THAT(undetermined(graph), ElementsAre(1000));
    // What hangs on it in full is no better off.
    Hang<G>(30, 900, G::Matrix::Identity(), &graph);
    EXPECT_THAT(undetermined(graph), ElementsAre(1000, 900));
    // Another edge measures what the first does not.
    GraphEdge<G> edge;
    edge.i = 5;
    edge.j = 31;
    edge.measurement = graph.nodes()[5].pose.Between(graph.nodes()[31].pose);
    ASSERT_TRUE(graph.AddEdge(edge).ok());
    EXPECT_THAT(undetermined(graph), IsEmpty());
    Hang<G>(5, 800, G::Matrix::Zero(), &graph);
    EXPECT_THAT(undetermined(graph), ElementsAre(800));
  }
}

TYPED_TEST(UndeterminedTest, ALongChainIsDetermined) {
  using G = TypeParam;
  PoseGraph<G> graph;
  for (int k = 0; k < 3000; ++k) {
    GraphNode<G> node;
    node.id = k;
    node.pose.translation()(0) = k;
    ASSERT_TRUE(graph.AddNode(node).ok());
    if (k == 0) continue;
    GraphEdge<G> edge;
    edge.i = k - 1;
    edge.j = k;
    edge.measurement.translation()(0) = 1;
    ASSERT_TRUE(graph.AddEdge(edge).ok());
  }
  Hang<G>(2999, 5000, NoRotation<G>(), &graph);
  FullSolveOptions options;
  options.init = InitMethod::kFile;
  EXPECT_THAT(SolveFull(options, &graph).undetermined, ElementsAre(5000));
}

TYPED_TEST(UndeterminedTest, WhatALossRejectsCountsAsMeasured) {
  using G = TypeParam;
  std::unique_ptr<ceres::LossFunction> tukey;
  std::string error;
  ASSERT_TRUE(ceres_costs::MakeLoss("tukey", 1, &tukey, &error)) << error;
  Subproblem<G> problem;
  problem.poses.resize(3);
  problem.num_free = 2;
  ceres_costs::RelativePoseTerm<G> far, soft;
  far.measurement.translation()(0) = 100;
  far.information = ceres_costs::PackedSymmetric<G::kDof>(G::Matrix::Identity().eval());
  soft.information = ceres_costs::PackedSymmetric<G::kDof>(NoRotation<G>());
  for (int k = 0; k < 2; ++k) {
    Factor<G>& factor = problem.factors.emplace_back();
    factor.i = 2;
    factor.j = k;
    factor.term = k == 0 ? &far : &soft;
  }
  problem.factors[0].loss = tukey.get();
  EXPECT_THAT(FindUndetermined(problem), ElementsAre(1));
}

// Every edge measures one direction, each another: next to nothing keeps the poses from running
// away.
TYPED_TEST(UndeterminedTest, OpenDirectionsDoNotRunAway) {
  using G = TypeParam;
  for (const Engine engine : {Engine::kBlock, Engine::kCeres}) {
    SCOPED_TRACE(EngineName(engine));
    PoseGraph<G> graph = MakeKnownGraph<G>(12, 0.1, 3).graph;
    std::mt19937_64 rng(3);
    std::normal_distribution<double> normal;
    for (std::size_t k = 0; k < graph.edges().size(); ++k) {
      typename G::Tangent u;
      for (int c = 0; c < G::kDof; ++c) u(c) = normal(rng);
      graph.edge(k).information = u * u.transpose();
    }
    FullSolveOptions options;
    options.engine = engine;
    options.init = InitMethod::kFile;
    const FullSolveReport report = SolveFull(options, &graph);
    ASSERT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_LE(report.cost_after, report.cost_before);
    EXPECT_EQ(report.undetermined.size(), 11);
    for (const GraphNode<G>& node : graph.nodes()) {
      EXPECT_LT(node.pose.translation().norm(), 100);
    }
  }
}

}  // namespace
}  // namespace hpgo
