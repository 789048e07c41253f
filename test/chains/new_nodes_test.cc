// Where new nodes are posed before anything is solved.

#include "gtest/gtest.h"
#include "hpgo/chains/condensed_graph.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

template <typename G>
class NewNodesTest : public testing::Test {
 protected:
  static constexpr int kEdges = 40;
  NewNodesTest() : graph_(HierarchyOptions(), true) {}

  static G Along(int axis, double distance) {
    typename G::Tangent d = G::Tangent::Zero();
    d(axis) = distance;
    return G().Plus(d);
  }
  static EdgeData<G> Edge(const G& measurement, double information) {
    EdgeData<G> data;
    data.weight = 1;
    data.term.measurement = measurement;
    data.term.information =
        ceres_costs::PackedSymmetric<G::kDof>((information * G::Matrix::Identity()).eval());
    return data;
  }
  // Nodes a metre apart, ahead, from a held one on.
  void AddRow() {
    G pose;
    graph_.AddNode(pose);
    graph_.SetHeld(0, true);
    for (int k = 1; k <= kEdges; ++k) {
      pose = pose * Along(0, 1);
      graph_.AddNode(pose);
      graph_.AddEdge(k - 1, k, Edge(Along(0, 1), 1));
    }
    graph_.Restructure();
  }
  // How far the next node goes to the side, where a stiffer edge to the first one has it.
  double GoesAside(double off, const G& pose) {
    const Index n = graph_.AddNode(pose);
    graph_.AddEdge(n - 1, n, Edge(Along(0, 1), 1));
    graph_.AddEdge(0, n, Edge(Along(0, kEdges + 1) * Along(1, off), 100));
    graph_.Restructure();
    return graph_.WorldPose(n).translation()(1);
  }

  CondensedGraph<G> graph_;
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(NewNodesTest, Groups);

TYPED_TEST(NewNodesTest, OneThatClosesALoopGoesToIt) {
  this->AddRow();
  EXPECT_DOUBLE_EQ(this->GoesAside(5, this->Along(0, this->kEdges + 1)), 5);
}

// Further than the chain behind it can bend at once: it would tear.
TYPED_TEST(NewNodesTest, NoneTearsTheChainBehindIt) {
  this->AddRow();
  EXPECT_DOUBLE_EQ(this->GoesAside(20, this->Along(0, this->kEdges + 1)), 0);
}

// Not even where the caller has posed it there.
TYPED_TEST(NewNodesTest, NorDoesTheCaller) {
  this->AddRow();
  EXPECT_DOUBLE_EQ(this->GoesAside(20, this->Along(0, this->kEdges + 1) * this->Along(1, 20)), 0);
}

// Among what came with it.
TYPED_TEST(NewNodesTest, TheChainBehindIsCountedThroughNewNodes) {
  this->graph_.AddNode(TypeParam());
  this->graph_.SetHeld(0, true);
  this->graph_.Restructure();
  TypeParam pose;
  for (int k = 1; k <= this->kEdges; ++k) {
    pose = pose * this->Along(0, 1);
    this->graph_.AddNode(pose);
    this->graph_.AddEdge(k - 1, k, this->Edge(this->Along(0, 1), 1));
  }
  EXPECT_DOUBLE_EQ(this->GoesAside(5, pose * this->Along(0, 1)), 5);
}

// It begins anew at one that closes a loop itself.
TYPED_TEST(NewNodesTest, TheChainBehindBeginsAtTheLastClosure) {
  this->AddRow();
  const TypeParam next = this->Along(0, this->kEdges + 1);
  const Index n = this->graph_.AddNode(next);
  this->graph_.AddEdge(n - 1, n, this->Edge(this->Along(0, 1), 1));
  this->graph_.AddEdge(0, n, this->Edge(next, 1));
  EXPECT_DOUBLE_EQ(this->GoesAside(5, next * this->Along(0, 1)), 0);
}

// A new neighbour that is held is where the caller has it, and so is what follows it.
TYPED_TEST(NewNodesTest, OneThatFollowsAHeldNodeStaysWithIt) {
  this->AddRow();
  const Index held = this->graph_.AddNode(this->Along(0, this->kEdges + 2));
  this->graph_.SetHeld(held, true);
  const Index n = this->graph_.AddNode(this->Along(0, this->kEdges + 1));
  this->graph_.AddEdge(this->kEdges, n, this->Edge(this->Along(0, 1) * this->Along(1, 5), 1));
  this->graph_.AddEdge(held, n, this->Edge(this->Along(0, -1), 100));
  this->graph_.AddEdge(0, n, this->Edge(this->Along(0, this->kEdges + 1), 1e-6));  // n is kept
  this->graph_.Restructure();
  EXPECT_DOUBLE_EQ(this->graph_.WorldPose(n).translation()(1), 0);
}

// A group moves rigidly, and what is inside is seen by no level above.
TYPED_TEST(NewNodesTest, AClosureThatIsTurnedFarHoldsNoGroupTogether) {
  this->AddRow();
  for (const double turn : {0.3, 1.}) {
    typename TypeParam::Tangent d = TypeParam::Tangent::Zero();
    d(TypeParam::kDof - 1) = turn;
    const Index e =
        this->graph_.AddEdge(0, this->kEdges, this->Edge(this->Along(0, this->kEdges).Plus(d), 1));
    this->graph_.Restructure();
    const Index edge = this->graph_.LevelEdgeOf(e);
    EXPECT_EQ(this->graph_.hierarchy().level(0).edges[edge].weight > 0, turn < 0.5);
  }
}

// The paper's weights stay what they are.
TYPED_TEST(NewNodesTest, WhereNoChainsAreCondensedItDoes) {
  CondensedGraph<TypeParam> graph(HierarchyOptions(), false);
  for (int k = 0; k < 2; ++k) graph.AddNode(TypeParam());
  typename TypeParam::Tangent d = TypeParam::Tangent::Zero();
  d(TypeParam::kDof - 1) = 1;
  graph.AddEdge(0, 1, this->Edge(TypeParam(), 1));
  const Index e = graph.AddEdge(0, 1, this->Edge(TypeParam().Plus(d), 1));
  graph.Restructure();
  EXPECT_EQ(graph.hierarchy().level(0).edges[graph.LevelEdgeOf(e)].weight, 1);
}

// An edge that does not say where its end is holds no chain together.
TYPED_TEST(NewNodesTest, WhatIsNotMeasuredIsTheCallers) {
  this->AddRow();
  EdgeData<TypeParam> turn = this->Edge(TypeParam(), 0);
  typename TypeParam::Matrix information = TypeParam::Matrix::Zero();
  information.diagonal().template tail<TypeParam::kRotationDof>().setOnes();
  turn.term.information = ceres_costs::PackedSymmetric<TypeParam::kDof>(information);
  const Index n = this->graph_.AddNode(this->Along(1, 7));
  this->graph_.AddEdge(0, n, turn);
  this->graph_.Restructure();
  EXPECT_DOUBLE_EQ(this->graph_.WorldPose(n).translation()(1), 7);
}

}  // namespace
}  // namespace hpgo
