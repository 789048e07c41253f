#include "hpgo/chains/span_tree.h"

#include <algorithm>
#include <cstdlib>

#include "Eigen/Cholesky"
#include "ceres_costs/factor_term.h"

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

// T_i_j of the measurement where the edge is linearized.
template <typename G>
G RelativePose(const ChainEdge<G>& edge) {
  return edge.reversed ? edge.Y.Inverse() : edge.Y;
}

template <typename G>
bool TurnsTooFar(const ChainEdge<G>& edge) {
  return IsTwisted(edge.term.measurement, RelativePose(edge));
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
G SpanTree<G>::Relax(Index s) {
  Span& span = spans_[s];
  span.stale = true;
  G T;
  if (span.height > 0) {
    T = Relax(span.items[0]);
    return (T * Relax(span.items[1])).Normalized();
  }
  for (int k = 0; k < span.count; ++k) {
    ChainEdge<G>& edge = edges_[span.items[k]];
    edge.Y = edge.reversed ? edge.term.measurement.Inverse() : edge.term.measurement;
    T = T * edge.Y;
  }
  return T.Normalized();
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
  const Tangent innovation = product.LocalCoordinates(T) - shift;
  const Tangent pull = sum.llt().solve(innovation);
  G rest = T;
  for (int k = 0; k + 1 < leaf.count; ++k) {
    const G& Y = edges_[leaf.items[k]].Y;
    poses[k] = Y.Retract(models[k].shift + gains[k] * pull);
    rest = poses[k].Between(rest);
  }
  poses[leaf.count - 1] = rest.Normalized();
}

template <typename G>
double SpanTree<G>::CostOf(const ChainEdge<G>& edge) const {
  ceres_costs::FactorTerm<G> factor;
  factor.term = &edge.term;
  factor.convention = convention_;
  return FactorCost(factor, false, RelativePose(edge));
}

// `tolerance` below zero: whatever the model may miss.
template <typename G>
void SpanTree<G>::SettleSpan(Index s, const G& T, double tolerance, Settled* settled) {
  Span& span = spans_[s];
  if (!(MissedAt(Model(s), T) > tolerance)) return;
  if (span.height == 0) {
    G poses[kLeafEdges];
    DistributeLeaf(span, T, poses);
    for (int k = 0; k < span.count; ++k) {
      ChainEdge<G>& edge = edges_[span.items[k]];
      settled->before.emplace_back(span.items[k], edge.Y);
      settled->gained += CostOf(edge);
      const typename G::Tangent moved = edge.Y.LocalCoordinates(poses[k]);
      settled->turn = std::max(settled->turn, moved.template tail<G::kRotationDof>().norm());
      edge.Y = poses[k];
      settled->gained -= CostOf(edge);
    }
    ComputeLeaf(&span);
    return;
  }
  const SplitPose<G> split =
      Distribute(spans_[span.items[0]].model, spans_[span.items[1]].model, T);
  SettleSpan(span.items[0], split.first, tolerance, settled);
  SettleSpan(span.items[1], split.second, tolerance, settled);
  span.model = Join(spans_[span.items[0]].model, spans_[span.items[1]].model, split);
}

template <typename G>
void SpanTree<G>::Undo(const Settled& settled) {
  for (const auto& [e, Y] : settled.before) {
    edges_[e].Y = Y;
    MarkStale(edges_[e].leaf);
  }
}

// Gauss-Newton steps, each from where the last one ended, until an edge turns by less than `still`
// and no model misses more than `tolerance`. The ends go to T in steps within reach; one that turns
// an edge further than a linearization can reach is made shorter. Where that does not help the
// edges are knotted, and the way begins at their measurements instead. At T a step that raises the
// cost is the last and is taken back: bent far enough, such steps would go anywhere, and the middle
// of what they bend, or of what does not get to T, is no part for a chain.
template <typename G>
int SpanTree<G>::SettleInTurns(Index root, const G& T, double tolerance, double still) {
  constexpr int kMaxTurns = 16;  // a half turn in steps within reach, and as many again
  constexpr double kShorter = 0.3, kShortest = 0.02;
  int edges = 0;
  double again = tolerance, part = 1;
  bool arrived = false, untied = false;
  for (int turn = 0; turn < kMaxTurns; ++turn) {
    const StepWithinReach<G> step = TowardsWithinReach(Model(root), T, part);
    Settled settled;
    SettleSpan(root, step.T, again, &settled);
    if (settled.before.empty()) break;
    edges += static_cast<int>(settled.before.size());
    if (arrived && !(settled.gained >= 0)) {
      Undo(settled);
      // More than the model may miss, and so more than rounding: it is out of reach here.
      if (tolerance > 0 && settled.gained < -tolerance * tolerance) {
        unfit_.push_back(edges_[settled.before[settled.before.size() / 2].first].edge);
      }
      break;
    }
    if (!arrived && !(settled.turn <= kReach)) {
      Undo(settled);
      if (untied) {
        const Span& span = spans_[root];
        unfit_.push_back(edges_[LastEdge(span.height > 0 ? span.items[0] : root)].edge);
        break;
      }
      part *= kShorter;
      if (part < kShortest) {
        Relax(root);
        untied = true;
        part = 1;
      }
      continue;
    }
    for (const auto& [e, Y] : settled.before) {
      const ChainEdge<G>& edge = edges_[e];
      if (TurnsTooFar(edge)) unfit_.push_back(edge.edge);
    }
    part = 1;
    arrived = step.arrives;
    if (tolerance < 0 && settled.turn <= still && arrived) break;
    again = settled.turn > still ? -1 : tolerance;
  }
  return edges;
}

template <typename G>
int SpanTree<G>::Settle(Index root, const G& T, double tolerance) {
  constexpr double kSmallTurn = 0.01;  // rad; what it leaves is of second order
  return SettleInTurns(root, T, tolerance, kSmallTurn);
}

template <typename G>
void SpanTree<G>::SettleAll(Index root, const G& T) {
  constexpr double kStill = 1e-8;  // rad
  SettleInTurns(root, T, -1, kStill);
}

template <typename G>
void SpanTree<G>::LinearizeAt(Index s, const std::function<G(const ChainEdge<G>&)>& Y) {
  Span& span = spans_[s];
  span.stale = true;
  if (span.height > 0) {
    for (int k = 0; k < 2; ++k) LinearizeAt(span.items[k], Y);
    return;
  }
  for (int k = 0; k < span.count; ++k) {
    ChainEdge<G>& edge = edges_[span.items[k]];
    edge.Y = Y(edge);
    if (TurnsTooFar(edge)) unfit_.push_back(edge.edge);
  }
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
