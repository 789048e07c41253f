// The block engine where a closure pulls a map apart.

#include <vector>

#include "block_solver_fixture.h"
#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "small_problems.h"

namespace hpgo {
namespace {

// A square sheet of poses 0.3 m apart, and an edge between two of its corners that is `pull` metres
// too long. Around its ends edges are stretched to a multiple of their length.
template <typename G>
PoseGraph<G> PulledSheet(double pull) {
  constexpr int kSide = 12;
  constexpr double kSpacing = 0.3;
  typename G::Matrix information = 400 * G::Matrix::Identity();
  information.diagonal().template head<G::kDim>().setConstant(100);
  const auto at = [](double x, double y) {
    typename G::Tangent d = G::Tangent::Zero();
    d(0) = x;
    d(1) = y;
    return G().Retract(d);
  };
  PoseGraph<G> graph;
  const auto connect = [&](int i, int j, const G& T_i_j) {
    GraphEdge<G> edge;
    edge.i = i;
    edge.j = j;
    edge.measurement = T_i_j;
    edge.information = information;
    EXPECT_TRUE(graph.AddEdge(edge).ok());
  };
  for (int k = 0; k < kSide * kSide; ++k) {
    GraphNode<G> node;
    node.id = k;
    node.pose = at(k % kSide * kSpacing, k / kSide * kSpacing);
    EXPECT_TRUE(graph.AddNode(node).ok());
  }
  for (int k = 0; k < kSide * kSide; ++k) {
    if (k % kSide + 1 < kSide) connect(k, k + 1, at(kSpacing, 0));
    if (k + kSide < kSide * kSide) connect(k, k + kSide, at(0, kSpacing));
  }
  typename G::Tangent turn = G::Tangent::Zero();
  turn(G::kDof - 1) = 1;
  connect(kSide + 1, kSide * kSide - kSide - 2, at(3, pull).Retract(turn));
  return graph;
}

template <typename G>
SubproblemSummary Solve(const PoseGraph<G>& graph, int iterations) {
  Problem<G> problem(graph);
  SubproblemOptions options = ToConvergence();
  options.max_iterations = iterations;
  return MakeBlockSolver<G>()->Solve(options, &problem.subproblem);
}

template <typename G>
class BlockSolverStretchedTest : public testing::Test {};
TYPED_TEST_SUITE(BlockSolverStretchedTest, BlockSolverGroups);

// With Gauss-Newton alone it is 1 % above it in the plane, and 10 % in space.
TYPED_TEST(BlockSolverStretchedTest, TenStepsEndAtTheOptimum) {
  const PoseGraph<TypeParam> graph = PulledSheet<TypeParam>(40);
  EXPECT_LT(Solve(graph, 10).final_cost, 1.0001 * Solve(graph, 300).final_cost);
}

// 124 in space where the model changes only for turns that are too long.
TYPED_TEST(BlockSolverStretchedTest, StepsThatRaiseTheCostTakeTheModelToo) {
  const SubproblemSummary summary = Solve(PulledSheet<TypeParam>(20), 300);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.iterations, 60);
}

// With the model of stretched edges alone it takes 123 iterations in the plane, and 82 in space.
TYPED_TEST(BlockSolverStretchedTest, TheLastStepsAreThoseOfGaussNewton) {
  const SubproblemSummary summary = Solve(PulledSheet<TypeParam>(10), 300);
  EXPECT_TRUE(summary.converged);
  EXPECT_LT(summary.iterations, 40);
}

}  // namespace
}  // namespace hpgo
