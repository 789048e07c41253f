// The tree of spans: the models of its spans, and the poses that follow from them.

#include <algorithm>

#include "Eigen/Cholesky"
#include "ceres_costs/factor_term.h"
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

// The edges of a leaf under a pull on its ends, which acts on each by the transport from there,
// transposed; returns T of the ends then.
template <typename G>
G SpanTree<G>::PullLeaf(const Span& leaf, const EdgeYield<G>* yields, typename G::Tangent pull,
                        Inside inside, G* poses) const {
  for (int k = leaf.count - 1; k >= 0; --k) {
    const G& Y = edges_[leaf.items[k]].Y;
    poses[k] = Y.Plus(yields[k].Under(pull, inside));
    pull = (Y.InverseAdjoint().transpose() * pull).eval();
  }
  G T;
  for (int k = 0; k < leaf.count; ++k) T = T * poses[k];
  return T.Normalized();
}

// Edges that turn under a pull do not quite get to T. What they miss pulls at all of them again, as
// long as that helps: the last one, which bears the rest, may be stiff.
template <typename G>
void SpanTree<G>::DistributeLeaf(const Span& leaf, const G& T, Inside inside, G* poses) const {
  constexpr int kMostTurns = 3;
  constexpr double kNothing = 1e-6;  // of chi2
  EdgeYield<G> yields[kLeafEdges];
  for (int k = 0; k < leaf.count; ++k) {
    const ChainEdge<G>& edge = edges_[leaf.items[k]];
    yields[k] = EdgeYield<G>(MeasurementOf(edge), edge.Y, convention_);
  }
  typename G::Tangent pull = PullTowards(leaf.model, T, inside);
  const int last = leaf.count - 1;
  const auto& stiffness = edges_[leaf.items[last]].term.information;
  G reached = PullLeaf(leaf, yields, pull, inside, poses);
  for (int turn = 1; turn < kMostTurns; ++turn) {
    const typename G::Tangent missed = T.Minus(reached);
    if (missed.dot(stiffness.Dense() * missed) < kNothing) break;
    G closer[kLeafEdges];
    pull += leaf.model.covariance.Dense().llt().solve(missed);
    const G next = PullLeaf(leaf, yields, pull, inside, closer);
    if (!(T.Minus(next).norm() < missed.norm())) break;
    reached = next;
    std::copy(closer, closer + leaf.count, poses);
  }
  poses[last] = (poses[last] * reached.Between(T)).Normalized();
}

template <typename G>
double SpanTree<G>::CostAt(Index s, const G& T, Inside inside, std::int64_t* edges) {
  constexpr double kSmall = 1e-3;  // of the cost: what a step misses that gains so much is less
  const SpanModel<G>& model = Model(s);
  if (inside == Inside::kYields) {
    if (IsLinearizedAt(model, T)) return model.cost;
  } else if (!(BendAt(model, T) > kFarOnTheWay)) {
    const double chi2 = ChiSquareAt(model, T);
    if (GainAt(model) <= kSmall * std::max(model.cost, chi2)) return chi2;
  }
  const Span& span = spans_[s];
  if (span.height > 0) {
    const SplitPose<G> split =
        Distribute(spans_[span.items[0]].model, spans_[span.items[1]].model, T, inside);
    return CostAt(span.items[0], split.first, inside, edges) +
           CostAt(span.items[1], split.second, inside, edges);
  }
  if (edges != nullptr) *edges += span.count;
  G poses[kLeafEdges];
  DistributeLeaf(span, T, inside, poses);
  double cost = 0;
  for (int k = 0; k < span.count; ++k) {
    const ChainEdge<G>& edge = edges_[span.items[k]];
    ceres_costs::FactorTerm<G> factor;
    factor.term = &edge.term;
    factor.convention = convention_;
    cost += FactorCost(factor, false, edge.reversed ? poses[k].Inverse() : poses[k]);
  }
  return cost;
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
