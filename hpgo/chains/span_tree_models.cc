// The tree of spans: the models of its spans, and the poses that follow from them.

#include "Eigen/Cholesky"
#include "hpgo/chains/span_tree.h"

namespace hpgo {

template <typename G>
void SpanTree<G>::ComputeLeaf(Span* leaf) {
  for (int k = 0; k < leaf->count; ++k) {
    const ChainEdge<G>& edge = edges_[leaf->items[k]];
    const SpanModel<G> next = ModelOf(edge);
    leaf->model = k == 0 ? next : Join(leaf->model, next);
  }
}

template <typename G>
const SpanModel<G>& SpanTree<G>::Model(Index s) {
  Span& span = spans_[s];
  if (!span.stale) return span.model;
  if (span.height == 0) {
    ComputeLeaf(&span);
  } else {
    span.model = Join(Model(span.items[0]), Model(span.items[1]));
  }
  span.stale = false;
  return span.model;
}

template <typename G>
void SpanTree<G>::PrepareFirst(Index root) {
  while (spans_[root].height > 0) {
    Model(spans_[root].items[0]);
    root = spans_[root].items[1];
  }
}

template <typename G>
void SpanTree<G>::DistributeLeaf(const Span& leaf, const G& T, G* poses) const {
  using Matrix = typename G::Matrix;
  using Tangent = typename G::Tangent;
  SpanModel<G> models[kLeafEdges];
  Matrix gains[kLeafEdges];  // C_k times the transpose of the transport to the end
  Matrix sum = Matrix::Zero(), transport = Matrix::Identity();
  Tangent shift = Tangent::Zero();
  G product;
  for (int k = leaf.count - 1; k >= 0; --k) {
    const ChainEdge<G>& edge = edges_[leaf.items[k]];
    models[k] = ModelOf(edge);
    gains[k].noalias() = models[k].covariance.Dense() * transport.transpose();
    sum.noalias() += transport * gains[k];
    shift.noalias() += transport * models[k].shift;
    transport = transport * edge.Y.InverseAdjoint();
    product = edge.Y * product;
  }
  const Tangent innovation = T.Minus(product) - shift;
  const Tangent pull = sum.llt().solve(innovation);
  G rest = T;
  for (int k = 0; k + 1 < leaf.count; ++k) {
    const G& Y = edges_[leaf.items[k]].Y;
    poses[k] = Y.Plus(models[k].shift + gains[k] * pull);
    rest = poses[k].Between(rest);
  }
  poses[leaf.count - 1] = rest.Normalized();
}

template <typename G>
SplitPose<G> SpanTree<G>::PoseOf(Index edge, const G& T) {
  // The path from the root.
  Index path[64];
  int depth = 0;
  for (Index s = edges_[edge].leaf; s >= 0; s = spans_[s].parent) path[depth++] = s;
  Model(path[depth - 1]);
  G before, target = T;  // of the span, from the first node, and of its ends
  for (--depth; depth > 0; --depth) {
    const Span& span = spans_[path[depth]];
    const SplitPose<G> split =
        Distribute(spans_[span.items[0]].model, spans_[span.items[1]].model, target);
    const bool left = span.items[0] == path[depth - 1];
    if (!left) before = before * split.first;
    target = left ? split.first : split.second;
  }
  const Span& leaf = spans_[path[0]];
  G poses[kLeafEdges];
  DistributeLeaf(leaf, target, poses);
  int k = 0;
  while (leaf.items[k] != edge) before = before * poses[k++];
  return {before, poses[k]};
}

template class SpanTree<ceres_costs::SE2>;
template class SpanTree<ceres_costs::SE3>;
template class SpanTree<ceres_costs::YawPose>;

}  // namespace hpgo
