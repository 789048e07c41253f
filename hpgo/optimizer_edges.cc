// Optimizer: edges by their ends, and what a caller's information weighs.

#include <algorithm>

#include "hpgo/graph/validate.h"
#include "hpgo/optimizer_impl.h"

namespace hpgo {

// With e_m = B e_i, B = diag(R_z', I), the weight e_i' Omega e_i is e_m' B Omega B' e_m.
template <typename G>
typename G::Matrix StoredInformation(InfoFrame frame, const G& measurement,
                                     const typename G::Matrix& information) {
  if (frame == InfoFrame::kMeasurement) return information;
  typename G::Matrix B = G::Matrix::Identity();
  B.template topLeftCorner<G::kDim, G::kDim>() = measurement.Normalized().matrix().transpose();
  const typename G::Matrix rotated = B * information * B.transpose();
  return 0.5 * (rotated + rotated.transpose());
}
template SE2::Matrix StoredInformation(InfoFrame, const SE2&, const SE2::Matrix&);
template SE3::Matrix StoredInformation(InfoFrame, const SE3&, const SE3::Matrix&);
template YawPose::Matrix StoredInformation(InfoFrame, const YawPose&, const YawPose::Matrix&);

template <typename G>
Result<std::vector<EdgeEnds>> Optimizer<G>::Impl::EdgesOf(NodeId id) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  std::vector<EdgeEnds> edges;
  graph_.ForEachEdgeOf(*node, [&](Index edge, Index) {
    const Index i = graph_.End(edge, 0);
    const NodeId j = ids_[graph_.End(edge, 1)];
    edges.push_back({IdOf(edge), i == kNone ? j : ids_[i], j});
  });
  std::reverse(edges.begin(), edges.end());
  return edges;
}

template <typename G>
Result<std::vector<EdgeEnds>> Optimizer<G>::EdgesOf(NodeId id) const {
  return impl_->EdgesOf(id);
}

template <typename G>
Result<std::vector<EdgeEnds>> Optimizer<G>::RemoveEdges(NodeId i, NodeId j) {
  for (const NodeId id : {i, j}) {
    if (!HasNode(id)) return Status(StatusCode::kNotFound, "no node " + std::to_string(id));
  }
  if (i == j) return Status(StatusCode::kInvalidArgument, EdgeName(i, j) + ": a self edge");
  std::vector<EdgeEnds> gone = *EdgesOf(i);
  const auto elsewhere = [&](const EdgeEnds& edge) { return edge.i != j && edge.j != j; };
  gone.erase(std::remove_if(gone.begin(), gone.end(), elsewhere), gone.end());
  for (const EdgeEnds& edge : gone) {
    const Status status = RemoveEdge(edge.id);
    if (!status.ok()) return status;
  }
  return gone;
}

template <typename G>
Result<std::vector<EdgeEnds>> Optimizer<G>::RemoveNode(NodeId id) {
  Result<std::vector<EdgeEnds>> edges = EdgesOf(id);
  if (!edges.ok()) return edges.status();
  const Status status = impl_->RemoveNode(id);
  if (!status.ok()) return status;
  return edges;
}

template <typename G>
Status Optimizer<G>::UpdateEdge(EdgeId edge, const G& measurement, const Matrix& information,
                                InfoFrame frame) {
  return impl_->UpdateEdge(edge, measurement, StoredInformation(frame, measurement, information),
                           nullptr);
}
template <typename G>
Status Optimizer<G>::UpdateEdge(EdgeId edge, const G& measurement, const Matrix& information,
                                Loss loss, InfoFrame frame) {
  return impl_->UpdateEdge(edge, measurement, StoredInformation(frame, measurement, information),
                           &loss);
}

template class Optimizer<SE2>;
template class Optimizer<SE3>;
template class Optimizer<YawPose>;

}  // namespace hpgo
