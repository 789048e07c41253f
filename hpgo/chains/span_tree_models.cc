// The tree of spans: the models of its spans, and the poses that follow from them.

#include "hpgo/chains/span_tree.h"

namespace hpgo {

template <typename G>
void SpanTree<G>::ComputeLeaf(Span* leaf) {
  GrowingSpan<G> span(convention_);
  for (int k = 0; k < leaf->count; ++k) {
    const ChainEdge<G>& edge = edges_[leaf->items[k]];
    span.Append(MeasurementOf(edge), edge.Y);
  }
  leaf->model = span.Model();
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

// A pull on the ends acts on each edge by the transport from there, transposed.
template <typename G>
void SpanTree<G>::DistributeLeaf(const Span& leaf, const G& T, Inside inside, G* poses) const {
  typename G::Tangent pull = PullTowards(leaf.model, T, inside);
  const int last = leaf.count - 1;
  for (int k = last; k >= 0; --k) {
    const ChainEdge<G>& edge = edges_[leaf.items[k]];
    if (k < last) {
      poses[k] = edge.Y.Plus(ShiftUnder(MeasurementOf(edge), edge.Y, convention_, pull, inside));
    }
    pull = (edge.Y.InverseAdjoint().transpose() * pull).eval();
  }
  G before;
  for (int k = 0; k < last; ++k) before = before * poses[k];
  poses[last] = before.Between(T).Normalized();
}

template <typename G>
SplitPose<G> SpanTree<G>::PoseOf(Index edge, const G& T, Inside inside) {
  // The path from the root.
  Index path[64];
  int depth = 0;
  for (Index s = edges_[edge].leaf; s >= 0; s = spans_[s].parent) path[depth++] = s;
  Model(path[depth - 1]);
  G before, target = T;  // of the span, from the first node, and of its ends
  for (--depth; depth > 0; --depth) {
    const Span& span = spans_[path[depth]];
    const SplitPose<G> split =
        Distribute(spans_[span.items[0]].model, spans_[span.items[1]].model, target, inside);
    const bool left = span.items[0] == path[depth - 1];
    if (!left) before = before * split.first;
    target = left ? split.first : split.second;
  }
  const Span& leaf = spans_[path[0]];
  G poses[kLeafEdges];
  DistributeLeaf(leaf, target, inside, poses);
  int k = 0;
  while (leaf.items[k] != edge) before = before * poses[k++];
  return {before, poses[k]};
}

template class SpanTree<ceres_costs::SE2>;
template class SpanTree<ceres_costs::SE3>;
template class SpanTree<ceres_costs::YawPose>;

}  // namespace hpgo
