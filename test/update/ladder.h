// A map that is mostly chains, and what it takes to close another loop in it.
#pragma once

#include "hpgo/graph/pose_graph.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

inline constexpr int kRungs = 10, kTail = 100;  // m

template <typename G>
G Ahead(double distance, double turn = 0) {
  typename G::Tangent d = G::Tangent::Zero();
  d(0) = distance;
  d(G::kDof - 1) = turn;
  return G().Plus(d);
}

template <typename G>
G Aside(double distance) {
  typename G::Tangent d = G::Tangent::Zero();
  d(1) = distance;
  return G().Plus(d);
}

// With a standard deviation of a centimetre, or a hundredth of a radian.
template <typename G>
EdgeData<G> Measuring(const G& T_i_j) {
  EdgeData<G> data;
  data.term = {T_i_j, ceres_costs::PackedSymmetric<G::kDof>((1e4 * G::Matrix::Identity()).eval())};
  return data;
}

// A lane of `length` m ahead and back again a metre aside, a node a metre, with a rung every
// `rungs` m. From where it began a tail goes on for `tail` m. All edges fit.
template <typename G>
PoseGraph<G> Ladder(int length, int rungs = kRungs, int tail = kTail) {
  PoseGraph<G> graph;
  for (int k = 0; k < length; ++k) (void)graph.AddNode({k, Ahead<G>(k), false});
  for (int k = 0; k < length + tail; ++k) {
    (void)graph.AddNode({length + k, Aside<G>(1) * Ahead<G>(length - 1 - k), false});
  }
  GraphEdge<G> edge;
  edge.information = Measuring(G()).term.information.Dense();
  const auto connect = [&](int i, int j) {
    edge.i = i;
    edge.j = j;
    edge.measurement = graph.nodes()[i].pose.Between(graph.nodes()[j].pose);
    (void)graph.AddEdge(edge);
  };
  for (int k = 1; k < 2 * length + tail; ++k) connect(k - 1, k);
  for (int k = 0; k < length - 1; k += rungs) connect(k, 2 * length - 1 - k);
  return graph;
}

}  // namespace hpgo
