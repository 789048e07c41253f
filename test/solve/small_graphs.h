// Small pose graphs with a known truth, for the tests of this folder.
#pragma once

#include <random>
#include <vector>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

template <typename G>
struct KnownGraph {
  PoseGraph<G> graph;
  std::vector<G> truth;  // by node index
};

template <typename G>
G RandomPose(std::mt19937_64* rng, double length, double angle) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  typename G::Tangent d;
  for (int k = 0; k < G::kDof; ++k) d(k) = uniform(*rng) * (k < G::kDim ? length : angle);
  return G().Retract(d);
}

// Symmetric positive definite, dense, of eigenvalues of 1 and more.
template <typename G>
typename G::Matrix RandomInformation(std::mt19937_64* rng) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  typename G::Matrix a;
  for (int k = 0; k < a.size(); ++k) a.data()[k] = uniform(*rng);
  return a * a.transpose() + G::Matrix::Identity();
}

// A walk of `nodes` nodes with ids first_id, first_id + 1, ... : odometry, and a loop closure from
// every third node to the seventh before it; every measurement off by up to `noise` in each
// coordinate. The nodes' poses are dead reckoning from the true first pose.
template <typename G>
KnownGraph<G> MakeKnownGraph(int nodes, double noise, unsigned seed, NodeId first_id = 0) {
  std::mt19937_64 rng(seed);
  KnownGraph<G> known;
  for (int k = 0; k < nodes; ++k) {
    known.truth.push_back(k == 0 ? RandomPose<G>(&rng, 3, 1)
                                 : known.truth.back() * RandomPose<G>(&rng, 1, 0.7));
  }
  const auto edge = [&](int i, int j) {
    GraphEdge<G> e;
    e.i = i;
    e.j = j;
    e.measurement = known.truth[i].Between(known.truth[j]) * RandomPose<G>(&rng, noise, noise);
    e.information = RandomInformation<G>(&rng);
    return e;
  };
  std::vector<GraphEdge<G>> edges;
  for (int k = 0; k < nodes; ++k) {
    GraphNode<G> node;
    node.id = first_id + k;
    if (k > 0) edges.push_back(edge(k - 1, k));
    node.pose =
        k == 0 ? known.truth[0] : known.graph.nodes().back().pose * edges.back().measurement;
    (void)known.graph.AddNode(node);
  }
  for (int k = 7; k < nodes; k += 3) edges.push_back(edge(k, k - 7));
  for (const GraphEdge<G>& e : edges) (void)known.graph.AddEdge(e);
  return known;
}

// The largest |tangent| between the poses of the graph and `poses`.
template <typename G>
double LargestDistance(const PoseGraph<G>& graph, const std::vector<G>& poses) {
  double largest = 0;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double d = graph.nodes()[k].pose.LocalCoordinates(poses[k]).norm();
    if (!(d <= largest)) largest = d;  // a NaN stays
  }
  return largest;
}

}  // namespace hpgo
