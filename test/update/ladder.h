// A map that is mostly chains, and a closure as far off as one likes.
#pragma once

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// A lane of `length` m ahead and back again a metre aside, a node a metre, with a rung every
// `rungs` m; from where it began a tail goes on for
// `tail` m. All edges fit.
inline constexpr int kRungs = 10, kTail = 100;

template <typename G>
G Ahead(double distance, double turn = 0) {
  typename G::Tangent d = G::Tangent::Zero();
  d(0) = distance;
  d(G::kDof - 1) = turn;
  return G().Plus(d);
}

template <typename G>
PoseGraph<G> Ladder(int length, int rungs = kRungs, int tail = kTail) {
  PoseGraph<G> graph;
  GraphEdge<G> edge;
  edge.information = 1e4 * G::Matrix::Identity();
  const auto add = [&](int k, const G& pose) { (void)graph.AddNode({k, pose, false}); };
  const auto connect = [&](int i, int j) {
    edge.i = i;
    edge.j = j;
    edge.measurement = graph.nodes()[i].pose.Between(graph.nodes()[j].pose);
    (void)graph.AddEdge(edge);
  };
  G beside;  // a metre to the left
  typename G::Tangent d = G::Tangent::Zero();
  d(1) = 1;
  beside = G().Plus(d);
  for (int k = 0; k < length; ++k) add(k, Ahead<G>(k));
  for (int k = 0; k < length + tail; ++k) add(length + k, beside * Ahead<G>(length - 1 - k));
  for (int k = 1; k < 2 * length + tail; ++k) connect(k - 1, k);
  for (int k = 0; k < length - 1; k += rungs) connect(k, 2 * length - 1 - k);
  return graph;
}

}  // namespace hpgo
