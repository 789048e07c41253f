// The tree of spans: its edges, and cutting, joining and balancing.

#include "hpgo/chains/span_tree.h"

#include <algorithm>
#include <cstdlib>

#include "Eigen/Cholesky"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

template <typename G>
ceres_costs::PackedSymmetric<G::kDof> Covariance(const ceres_costs::RelativePoseTerm<G>& term) {
  return ceres_costs::PackedSymmetric<G::kDof>(
      term.information.Dense().ldlt().solve(G::Matrix::Identity()).eval());
}

}  // namespace

template <typename G>
Index SpanTree<G>::NewSpan() {
  if (!free_spans_.empty()) {
    const Index span = free_spans_.back();
    free_spans_.pop_back();
    spans_[span] = Span();
    return span;
  }
  spans_.push_back(Span());
  return static_cast<Index>(spans_.size()) - 1;
}

template <typename G>
void SpanTree<G>::FreeSpan(Index span) {
  free_spans_.push_back(span);
}

template <typename G>
Index SpanTree<G>::AddEdge(const ceres_costs::RelativePoseTerm<G>& term, Index name,
                           bool reversed) {
  Index e;
  if (free_edges_.empty()) {
    e = static_cast<Index>(edges_.size());
    edges_.push_back(ChainEdge<G>());
  } else {
    e = free_edges_.back();
    free_edges_.pop_back();
  }
  ChainEdge<G>& edge = edges_[e];
  edge.term = term;
  edge.covariance = Covariance(term);
  edge.Y = reversed ? term.measurement.Inverse() : term.measurement;
  edge.edge = name;
  edge.reversed = reversed;
  NewLeaf(e);
  return e;
}

template <typename G>
void SpanTree<G>::FreeEdge(Index edge) {
  free_edges_.push_back(edge);
}

template <typename G>
Index SpanTree<G>::NewLeaf(Index edge) {
  const Index leaf = NewSpan();
  spans_[leaf].items[0] = edge;
  spans_[leaf].count = 1;
  edges_[edge].leaf = leaf;
  return leaf;
}

template <typename G>
void SpanTree<G>::SetTerm(Index edge, const ceres_costs::RelativePoseTerm<G>& term) {
  edges_[edge].term = term;
  edges_[edge].covariance = Covariance(term);
  MarkStale(edges_[edge].leaf);
}

template <typename G>
void SpanTree<G>::MarkStale(Index span) {
  for (; span >= 0; span = spans_[span].parent) spans_[span].stale = true;
}

template <typename G>
Index SpanTree<G>::RootOf(Index edge) const {
  Index span = edges_[edge].leaf;
  while (spans_[span].parent >= 0) span = spans_[span].parent;
  return span;
}

template <typename G>
Index SpanTree<G>::FirstEdge(Index root) const {
  while (spans_[root].height > 0) root = spans_[root].items[0];
  return spans_[root].items[0];
}

template <typename G>
Index SpanTree<G>::LastEdge(Index root) const {
  while (spans_[root].height > 0) root = spans_[root].items[1];
  return spans_[root].items[spans_[root].count - 1];
}

// A span over two others.
template <typename G>
Index SpanTree<G>::MakeInner(Index left, Index right) {
  const Index s = NewSpan();
  Span& span = spans_[s];
  span.items[0] = left;
  span.items[1] = right;
  span.count = 2;
  Adopt(s);
  return s;
}

// Takes the children in, whatever they are.
template <typename G>
void SpanTree<G>::Adopt(Index s) {
  Span& span = spans_[s];
  for (int k = 0; k < 2; ++k) spans_[span.items[k]].parent = s;
  span.height =
      static_cast<std::int16_t>(1 + std::max(Height(span.items[0]), Height(span.items[1])));
  span.stale = true;
}

// A span over two whose heights differ by up to two: a rotation may be needed.
template <typename G>
Index SpanTree<G>::Balanced(Index left, Index right) {
  const int difference = Height(left) - Height(right);
  if (std::abs(difference) < 2) return MakeInner(left, right);
  // The higher one's outer and inner child; an inner one that is higher still is taken apart.
  const bool left_heavy = difference > 0;
  const Index high = left_heavy ? left : right;
  const Index outer = spans_[high].items[left_heavy ? 0 : 1];
  const Index inner = spans_[high].items[left_heavy ? 1 : 0];
  FreeSpan(high);
  if (Height(inner) <= Height(outer)) {
    return left_heavy ? MakeInner(outer, MakeInner(inner, right))
                      : MakeInner(MakeInner(left, inner), outer);
  }
  const Index a = spans_[inner].items[0], b = spans_[inner].items[1];
  FreeSpan(inner);
  return left_heavy ? MakeInner(MakeInner(outer, a), MakeInner(b, right))
                    : MakeInner(MakeInner(left, a), MakeInner(b, outer));
}

template <typename G>
Index SpanTree<G>::Concatenate(Index left, Index right) {
  if (left == kNone) return right;
  if (right == kNone) return left;
  Span &a = spans_[left], &b = spans_[right];
  if (a.height == 0 && b.height == 0 && a.count + b.count <= kLeafEdges) {
    for (int k = 0; k < b.count; ++k) {
      a.items[a.count++] = b.items[k];
      edges_[b.items[k]].leaf = left;
    }
    a.stale = true;
    a.parent = kNone;
    FreeSpan(right);
    return left;
  }
  Index root;
  if (std::abs(a.height - b.height) < 2 && (a.height > 0) == (b.height > 0)) {
    root = MakeInner(left, right);
  } else if (a.height > b.height) {
    const Index outer = a.items[0], inner = a.items[1];
    FreeSpan(left);
    root = Balanced(outer, Concatenate(inner, right));
  } else {
    const Index outer = b.items[1], inner = b.items[0];
    FreeSpan(right);
    root = Balanced(Concatenate(left, inner), outer);
  }
  spans_[root].parent = kNone;
  return root;
}

template <typename G>
void SpanTree<G>::Split(Index edge, Index* before, Index* after) {
  Index s = edges_[edge].leaf;
  Index up = spans_[s].parent;
  {
    const Span leaf = spans_[s];
    const int at =
        static_cast<int>(std::find(leaf.items, leaf.items + leaf.count, edge) - leaf.items);
    const auto part = [&](int from, int to) {
      if (from == to) return kNone;
      const Index span = NewSpan();
      for (int k = from; k < to; ++k) {
        spans_[span].items[spans_[span].count++] = leaf.items[k];
        edges_[leaf.items[k]].leaf = span;
      }
      return span;
    };
    *before = part(0, at);
    *after = part(at + 1, leaf.count);
    edges_[edge].leaf = kNone;
  }
  // Upwards: each ancestor gives its other child to one of the sides.
  Index child = s;
  FreeSpan(s);
  while (up >= 0) {
    const Index parent = spans_[up].parent;
    const Index left = spans_[up].items[0], right = spans_[up].items[1];
    FreeSpan(up);
    if (left == child) {
      spans_[right].parent = kNone;
      *after = Concatenate(*after, right);
    } else {
      spans_[left].parent = kNone;
      *before = Concatenate(left, *before);
    }
    child = up;
    up = parent;
  }
}

template <typename G>
Index SpanTree<G>::Reversed(Index root) {
  std::vector<Index> order;
  const auto collect = [&](const auto& self, Index s) -> void {
    if (spans_[s].height > 0) {
      self(self, spans_[s].items[0]);
      self(self, spans_[s].items[1]);
      return;
    }
    order.insert(order.end(), spans_[s].items, spans_[s].items + spans_[s].count);
  };
  collect(collect, root);
  FreeTree(root);
  Index result = kNone;
  for (auto it = order.rbegin(); it != order.rend(); ++it) {
    ChainEdge<G>& edge = edges_[*it];
    edge.Y = edge.Y.Inverse();
    edge.reversed = !edge.reversed;
    result = Concatenate(result, NewLeaf(*it));
  }
  return result;
}

template <typename G>
void SpanTree<G>::FreeTree(Index root) {
  if (spans_[root].height > 0) {
    FreeTree(spans_[root].items[0]);
    FreeTree(spans_[root].items[1]);
  }
  FreeSpan(root);
}

template <typename G>
const char* SpanTree<G>::Inconsistency(Index s) const {
  const Span& span = spans_[s];
  if (span.height == 0) {
    if (span.count < 1 || span.count > kLeafEdges) return "size of a leaf";
    for (int k = 0; k < span.count; ++k) {
      if (edges_[span.items[k]].leaf != s) return "leaf of a chain edge";
    }
    return "";
  }
  for (int k = 0; k < 2; ++k) {
    if (spans_[span.items[k]].parent != s) return "parent of a span";
    const char* below = Inconsistency(span.items[k]);
    if (*below != '\0') return below;
    if (spans_[span.items[k]].stale && !span.stale) return "a span that missed a change";
  }
  const int a = Height(span.items[0]), b = Height(span.items[1]);
  if (span.height != 1 + std::max(a, b)) return "height of a span";
  if (std::abs(a - b) > 1) return "balance of a span";
  return "";
}

template class SpanTree<SE2>;
template class SpanTree<SE3>;
template class SpanTree<YawPose>;

}  // namespace hpgo
