// A map that a closure pulls apart, for the tests of what stretched edges do to steps.
#pragma once

#include "gtest/gtest.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

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

}  // namespace hpgo
