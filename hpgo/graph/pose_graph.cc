#include "hpgo/graph/pose_graph.h"

#include <string>

namespace hpgo {

template <typename G>
Result<int> PoseGraph<G>::AddNode(const GraphNode<G>& node) {
  const int index = static_cast<int>(nodes_.size());
  if (!index_.emplace(node.id, index).second) {
    return Status(StatusCode::kAlreadyExists, "node " + std::to_string(node.id) + " exists");
  }
  nodes_.push_back(node);
  return index;
}

template <typename G>
Status PoseGraph<G>::AddEdge(const GraphEdge<G>& edge) {
  const int size = static_cast<int>(nodes_.size());
  if (edge.i < 0 || edge.j < 0 || edge.i >= size || edge.j >= size) {
    return Status(StatusCode::kInvalidArgument, "edge between indices " + std::to_string(edge.i) +
                                                    " and " + std::to_string(edge.j) +
                                                    " of a graph of " + std::to_string(size));
  }
  if (edge.i == edge.j) {
    return Status(StatusCode::kInvalidArgument,
                  "self edge at node " + std::to_string(nodes_[edge.i].id));
  }
  edges_.push_back(edge);
  return Status::Ok();
}

template <typename G>
Status PoseGraph<G>::AddPrior(const GraphPrior<G>& prior) {
  if (prior.node < 0 || prior.node >= static_cast<int>(nodes_.size())) {
    return Status(StatusCode::kInvalidArgument, "prior at index " + std::to_string(prior.node) +
                                                    " of a graph of " +
                                                    std::to_string(nodes_.size()));
  }
  priors_.push_back(prior);
  return Status::Ok();
}

template <typename G>
void PoseGraph<G>::Reserve(std::size_t nodes, std::size_t edges) {
  nodes_.reserve(nodes);
  edges_.reserve(edges);
  index_.reserve(nodes);
}

template <typename G>
std::optional<int> PoseGraph<G>::Find(NodeId id) const {
  const auto it = index_.find(id);
  if (it == index_.end()) return std::nullopt;
  return it->second;
}

template class PoseGraph<SE2>;
template class PoseGraph<SE3>;
template class PoseGraph<YawPose>;

}  // namespace hpgo
