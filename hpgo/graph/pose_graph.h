// A pose graph as plain data: what a file holds, what a full optimization solves. No Ceres.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"
#include "hpgo/graph/status.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// The caller's name of a node: any 64-bit number, sparse and in any order.
using NodeId = std::int64_t;

template <typename G>
struct GraphNode {
  NodeId id = 0;
  G pose;                // T_world_node
  bool fixed = false;    // never moves
  bool has_pose = true;  // false: no estimate was given; an initial guess makes one
};

template <typename G>
struct GraphEdge {
  int i = 0;  // index into nodes()
  int j = 0;
  G measurement;                                           // T_i_j
  typename G::Matrix information = G::Matrix::Identity();  // of the error, translation first
};

// A (possibly partial) measurement of one pose: e of Z^-1 X P, with X = T_world_node.
template <typename G>
struct GraphPrior {
  int node = 0;   // index into nodes()
  G measurement;  // Z = T_world_sensor
  G offset;       // P = T_node_sensor
  // Rank-deficient where only part of the pose is measured: zero rows are not measured.
  typename G::Matrix information = G::Matrix::Identity();
};

// Nodes, edges and priors in the order they were added. Copyable; one writer at a time.
template <typename G>
class PoseGraph {
 public:
  using Group = G;

  // The index of the new node; kAlreadyExists if the id is taken.
  Result<int> AddNode(const GraphNode<G>& node);
  // kInvalidArgument for an index out of range or a self edge.
  Status AddEdge(const GraphEdge<G>& edge);
  Status AddPrior(const GraphPrior<G>& prior);
  void Reserve(std::size_t nodes, std::size_t edges);

  // The index of the node called `id`, if there is one.
  std::optional<int> Find(NodeId id) const;

  const std::vector<GraphNode<G>>& nodes() const { return nodes_; }
  const std::vector<GraphEdge<G>>& edges() const { return edges_; }
  const std::vector<GraphPrior<G>>& priors() const { return priors_; }
  // Values may be changed in place; ids and the nodes' order may not.
  GraphNode<G>& node(int index) { return nodes_[index]; }
  GraphEdge<G>& edge(int index) { return edges_[index]; }
  GraphPrior<G>& prior(int index) { return priors_[index]; }

 private:
  std::vector<GraphNode<G>> nodes_;
  std::vector<GraphEdge<G>> edges_;
  std::vector<GraphPrior<G>> priors_;
  std::unordered_map<NodeId, int> index_;
};

using PoseGraph2d = PoseGraph<SE2>;
using PoseGraph3d = PoseGraph<SE3>;

extern template class PoseGraph<SE2>;
extern template class PoseGraph<SE3>;
extern template class PoseGraph<YawPose>;

}  // namespace hpgo
