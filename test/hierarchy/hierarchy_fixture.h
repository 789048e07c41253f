// What the tests of the hierarchy share: one that grows by noisy edges, and its coarse edges
// merged.
#pragma once

#include <cstddef>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

template <typename G>
class HierarchyFixture : public testing::Test {
 protected:
  G RandomPose(double size) {
    typename G::Tangent d;
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (int k = 0; k < G::kDof; ++k) d(k) = size * uniform(rng_);
    return G::Exp(d);
  }
  // A noisy measurement of `T_i_j` with dense information.
  EdgeData<G> RandomEdge(const G& T_i_j) {
    EdgeData<G> data;
    data.term.measurement = T_i_j * RandomPose(0.2);
    typename G::Matrix information = G::Matrix::Random();
    information = information * information.transpose() + G::Matrix::Identity();
    data.term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
    data.weight = ModularityWeight(data.term);
    return data;
  }
  EdgeData<G> RandomEdge() { return RandomEdge(RandomPose(1)); }
  // A chain of nodes with edges to random earlier ones, grouped after every node.
  void Grow(Hierarchy<G>* hierarchy, int nodes, double closures) {
    std::uniform_real_distribution<double> uniform(0, 1);
    G pose;
    for (int k = 0; k < nodes; ++k) {
      const Index n = hierarchy->AddNode(pose);
      const auto connect = [&](Index other) {
        edges_.push_back(
            hierarchy->AddEdge(other, n, RandomEdge(hierarchy->RelativePose(0, other, n))));
      };
      if (!nodes_.empty()) connect(nodes_.back());
      for (double c = closures; nodes_.size() > 10 && uniform(rng_) < c; c -= 1) {
        const Index other = nodes_[static_cast<std::size_t>(uniform(rng_) * nodes_.size() * 0.9)];
        connect(other);
      }
      nodes_.push_back(n);
      hierarchy->AssignGroups();
      pose = pose * RandomPose(1);
    }
  }
  void MergeAll(Hierarchy<G>* hierarchy) {
    for (int l = 1; l < hierarchy->num_levels(); ++l) {
      Level<G>& level = hierarchy->mutable_level(l);
      for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
        if (level.edges[e].alive) hierarchy->Merge(l, e);
        level.edges[e].dirty = false;
      }
      level.dirty.clear();
    }
  }

  std::mt19937 rng_{7};
  std::vector<Index> nodes_, edges_;
};

}  // namespace hpgo
