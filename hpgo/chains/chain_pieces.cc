// Where nodes are in chains, and chains cut there without being changed.

#include <algorithm>
#include <utility>

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
std::vector<typename SpanTree<G>::Piece> SpanTree<G>::Cut(Index root,
                                                          const std::vector<Index>& behind) {
  std::vector<Index> opened;  // the spans above the cuts
  for (const Index edge : behind) {
    for (Index s = edges_[edge].leaf; s >= 0; s = spans_[s].parent) opened.push_back(s);
  }
  const auto contains = [](const std::vector<Index>& list, Index item) {
    return std::find(list.begin(), list.end(), item) != list.end();
  };
  std::vector<Piece> pieces;
  Piece piece;
  bool empty = true;
  const auto append = [&](const SpanModel<G>& model) {
    piece.model = empty ? model : Join(piece.model, model);
    empty = false;
  };
  const auto visit = [&](const auto& self, Index s) -> void {
    if (!contains(opened, s)) return append(Model(s));
    const Span& span = spans_[s];
    if (span.height > 0) {
      self(self, span.items[0]);
      self(self, span.items[1]);
      return;
    }
    for (int k = 0; k < span.count; ++k) {
      append(ModelOf(edges_[span.items[k]]));
      if (!contains(behind, span.items[k])) continue;
      piece.last = span.items[k];
      pieces.push_back(std::exchange(piece, {}));
      empty = true;
    }
  };
  visit(visit, root);
  if (!empty) pieces.push_back(piece);
  return pieces;
}

template <typename G>
Index CondensedGraph<G>::ChainOfNode(Index n) const {
  if (nodes_[n].level_node != kNone || nodes_[n].loose) return kNone;
  Index chain = kNone;
  ForEachEdgeOf(n, [&](Index e, Index) {
    if (chain == kNone && edges_[e].place == Place::kChain) chain = ChainOf(e);
  });
  return chain;
}

template <typename G>
Index CondensedGraph<G>::EdgeInto(Index n) const {
  Index into = kNone;
  ForEachEdgeOf(n, [&](Index e, Index) {
    if (edges_[e].place == Place::kChain && EnteredBy(edges_[e].at) == n) into = edges_[e].at;
  });
  return into;
}

template <typename G>
std::vector<Stretch<G>> CondensedGraph<G>::CutChain(Index c, const std::vector<Index>& nodes) {
  const Chain& chain = chains_[c];
  const auto is_cut = [&](Index n) {
    return std::find(nodes.begin(), nodes.end(), n) != nodes.end();
  };
  std::vector<Index> behind;
  for (const Index n : nodes) {
    const Index into = ChainOfNode(n) == c ? EdgeInto(n) : kNone;
    if (into != kNone) behind.push_back(into);
  }
  std::vector<Stretch<G>> stretches;
  Index from = chain.node[0];
  for (const typename SpanTree<G>::Piece& piece : spans_.Cut(chain.root, behind)) {
    const Index to = piece.last == kNone ? chain.node[1] : EnteredBy(piece.last);
    if ((IsKept(from) || is_cut(from)) && (IsKept(to) || is_cut(to))) {
      const G T = WorldPose(from).Between(WorldPose(to));
      stretches.push_back({{from, to}, TermOfSpan(piece.model, T)});
    }
    from = to;
  }
  return stretches;
}

template std::vector<SpanTree<SE2>::Piece> SpanTree<SE2>::Cut(Index, const std::vector<Index>&);
template std::vector<SpanTree<SE3>::Piece> SpanTree<SE3>::Cut(Index, const std::vector<Index>&);
template std::vector<SpanTree<YawPose>::Piece> SpanTree<YawPose>::Cut(Index,
                                                                      const std::vector<Index>&);
template class CondensedGraph<SE2>;
template class CondensedGraph<SE3>;
template class CondensedGraph<YawPose>;

}  // namespace hpgo
