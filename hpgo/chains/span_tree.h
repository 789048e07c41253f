// Chains as balanced trees of spans, so that one is cut or joined in O(log n).
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "hpgo/chains/linearization_log.h"
#include "hpgo/chains/span.h"
#include "hpgo/hierarchy/chunked_vector.h"

namespace hpgo {

// An edge that is part of a chain.
template <typename G>
struct ChainEdge {
  ceres_costs::RelativePoseTerm<G> term;
  ceres_costs::PackedSymmetric<G::kDof> covariance;  // the inverse of its information
  G Y;                    // T_previous_next along the chain, where it is linearized
  Index edge = kNone;     // its name elsewhere
  Index leaf = kNone;     // the span that holds it
  bool reversed = false;  // the chain runs against its measurement

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.term, self.covariance, self.Y, self.edge, self.leaf, self.reversed);
  }
};

// What became of a chain that was to be linearized anew.
struct SettleResult {
  bool holds = true;  // its model does where its ends are; else an edge of it is unfit
  int edges = 0;      // that were linearized
};

// All chains of a graph. A chain is a tree whose leaves hold up to kLeafEdges edges in order; every
// span holds its model, computed from what is below when it was last linearized (`stale`: to be
// computed anew when next asked for). Heights are balanced as in an AVL tree. Not synchronized.
template <typename G>
class SpanTree {
 public:
  explicit SpanTree(ceres_costs::ErrorConvention convention) : convention_(convention) {}

  // --- Edges.
  // A new edge, linearized at its measurement, and a tree of it alone.
  Index AddEdge(const ceres_costs::RelativePoseTerm<G>& term, Index name, bool reversed);
  void FreeEdge(Index edge);
  const ChainEdge<G>& edge(Index edge) const { return edges_[edge]; }
  // Another measurement: what lies above is computed anew.
  void SetTerm(Index edge, const ceres_costs::RelativePoseTerm<G>& term);
  // The span of the edge alone.
  Index NewLeaf(Index edge);

  // --- Trees, named by their roots.
  Index RootOf(Index edge) const;
  // The chain of `first` followed by `second`; kNone is an empty one. O(difference in height).
  Index Concatenate(Index first, Index second);
  // Takes a tree apart at an edge: what comes before it, and what comes after; the edge itself
  // belongs to neither. O(log n).
  void Split(Index edge, Index* before, Index* after);
  // The same chain the other way round. O(n).
  Index Reversed(Index root);
  void FreeTree(Index root);
  // What the owner of a tree wants to find again from its root.
  void SetOwner(Index root, Index owner) { spans_[root].parent = ~owner - 1; }
  Index OwnerOf(Index root) const { return ~(spans_[root].parent + 1); }
  Index FirstEdge(Index root) const;
  Index LastEdge(Index root) const;
  int HeightOf(Index root) const { return spans_[root].height; }
  bool IsSingle(Index root) const { return spans_[root].height == 0 && spans_[root].count == 1; }

  // --- Models.
  const SpanModel<G>& Model(Index root);
  // Puts every edge where its measurement says, which is where a chain with a free end rests;
  // returns T of the ends there. O(n).
  G Relax(Index root);
  // Computes the models of all but the last leaf and the spans above it, which grow: so that a
  // chain that ends pays for no more than that. O(1) an edge, all told.
  void PrepareFirst(Index root);
  // Linearizes anew, with T of the ends of the chain, every stretch whose model may miss more than
  // `tolerance`, in sqrt(chi2) (MissedAt). What cannot get there stays as it was, but for what it
  // gained where it was there before: `lags`, the last time did not do it. `log`, unless null, goes
  // on with what is overwritten.
  SettleResult Settle(Index root, const G& T, double tolerance, bool lags = false,
                      LinearizationLog<G>* log = nullptr);
  // The same of every stretch, until nothing moves any more.
  SettleResult SettleAll(Index root, const G& T, bool lags = false);
  // The names of edges that Settle has found to be no part for a chain: turned against their
  // measurements by more than a linearization can reach, or amid a stretch whose step raises its
  // cost.
  std::vector<Index> TakeUnfit() { return std::exchange(unfit_, {}); }
  // Where all of a tree is linearized. O(n).
  void Remember(Index root, LinearizationLog<G>* log);
  // Puts back what the log has since `mark`, which it has no longer then, as long as the trees have
  // the same spans.
  void PutBack(const LogMark& mark, LinearizationLog<G>* log);
  // The cost of the edges, for T of the ends: of spans that rest and hardly bend (kFarOnTheWay) as
  // their models say, of others that of the edges, whose number is added to `edges`.
  double CostAt(Index root, const G& T, Inside inside, std::int64_t* edges = nullptr);
  // Whether a term of the ends at T can say what the model says (IsWithinTerm); else an edge of it
  // is unfit.
  bool FitsTerm(Index root, const G& T);
  // Linearizes every edge at Y, T_previous_next along the chain. O(n).
  void LinearizeAt(Index root, const std::function<G(const ChainEdge<G>&)>& Y);
  // An edge given T of the ends of its chain: T_first_previous, and T_previous_next. O(log n).
  SplitPose<G> PoseOf(Index edge, const G& T, Inside inside);
  // The chain cut behind each of these edges: the pieces in order, and the edge each ends with; the
  // last one ends with the chain. O(log n) a cut.
  struct Piece {
    SpanModel<G> model;
    Index last = kNone;
  };
  std::vector<Piece> Cut(Index root, const std::vector<Index>& behind);
  // visit(edge, Y): in order along the chain, with the relative poses.
  template <typename Visitor>
  void ForEachEdge(Index root, const G& T, Inside inside, Visitor&& visit) {
    VisitSpan(root, T, inside, visit);
  }

  std::size_t MemoryBytes() const {
    return spans_.MemoryBytes() + edges_.MemoryBytes() +
           (free_spans_.capacity() + free_edges_.capacity()) * sizeof(Index);
  }
  // Empty if all is well, else what is wrong with the tree below `root`.
  const char* Inconsistency(Index root) const;

 private:
  static constexpr int kLeafEdges = 16;

  struct Span {
    SpanModel<G> model;
    Index parent = kNone;     // of a root: below kNone, see SetOwner
    Index items[kLeafEdges];  // of a leaf: its edges; else its two children first
    std::int16_t height = 0;  // 0: a leaf
    std::int16_t count = 0;   // of items
    bool stale = true;

    template <typename Archive, typename Self>
    static void Fields(Archive& archive, Self& self) {
      archive(self.model, self.parent, self.height, self.count, self.stale);
      for (int k = 0; k < std::min<int>(self.count, kLeafEdges); ++k) archive(self.items[k]);
    }
  };

  Index NewSpan();
  void FreeSpan(Index span);
  Index MakeInner(Index left, Index right);
  void Adopt(Index span);
  Index Balanced(Index left, Index right);
  void MarkStale(Index span);
  Index Height(Index span) const { return spans_[span].height; }

  // span_tree_models.cc
  static EdgeMeasurement<G> MeasurementOf(const ChainEdge<G>& edge) {
    return {edge.term, edge.covariance, edge.reversed};
  }
  SpanModel<G> ModelOf(const ChainEdge<G>& edge) const {
    GrowingSpan<G> span(convention_);
    span.Append(MeasurementOf(edge), edge.Y);
    return span.Model();
  }
  void ComputeLeaf(Span* leaf);
  G PullLeaf(const Span& leaf, const EdgeYield<G>* yields, typename G::Tangent pull, Inside inside,
             G* poses) const;
  // The relative poses of a leaf's edges.
  void DistributeLeaf(const Span& leaf, const G& T, Inside inside, G* poses) const;

  // span_tree_settle.cc
  // Which spans a pass looks into: those that bend far; those that miss too much; or all, but of
  // the leaves those that miss too much.
  enum class Depth { kFar, kMissed, kLeaves };
  struct Pass {
    Depth depth = Depth::kMissed;
    double tolerance = 0;                                    // in sqrt(chi2); below zero: none
    double reach = std::numeric_limits<double>::infinity();  // rad, of an edge
    Index moved = kNone;                                     // a span looked into in any case
    bool Concerns(const SpanModel<G>& model, const G& T, bool is_inner) const;
  };
  struct Settled {
    double turn = 0;    // the largest of an edge, in rad
    double gained = 0;  // by which their cost fell
  };
  bool SettleSpan(Index span, const G& T, const Pass& pass, LinearizationLog<G>* log,
                  Settled* settled);
  void NameMiddle(Index root);
  struct Goal {
    G T;
    double tolerance = 0, still = 0;
    bool lags = false;
  };
  SettleResult GoTo(Index root, const Goal& goal, bool stays, LinearizationLog<G>* log);
  SettleResult SettleInTurns(Index root, const Goal& goal, LinearizationLog<G>* log);

  template <typename Visitor>
  void VisitSpan(Index s, const G& T, Inside inside, Visitor& visit) {
    Model(s);
    const Span& span = spans_[s];
    if (span.height == 0) {
      G poses[kLeafEdges];
      DistributeLeaf(span, T, inside, poses);
      for (int k = 0; k < span.count; ++k) visit(span.items[k], poses[k]);
      return;
    }
    const SplitPose<G> split =
        Distribute(spans_[span.items[0]].model, spans_[span.items[1]].model, T, inside);
    VisitSpan(span.items[0], split.first, inside, visit);
    VisitSpan(span.items[1], split.second, inside, visit);
  }

  ceres_costs::ErrorConvention convention_;
  ChunkedVector<Span, 6> spans_;
  ChunkedVector<ChainEdge<G>> edges_;
  std::vector<Index> free_spans_, free_edges_;
  std::vector<Index> unfit_;

 public:
  // What a saved state has of the fields above.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.spans_, self.edges_, self.free_spans_, self.free_edges_, self.unfit_);
  }
};

extern template class SpanTree<ceres_costs::SE2>;
extern template class SpanTree<ceres_costs::SE3>;
extern template class SpanTree<ceres_costs::YawPose>;

}  // namespace hpgo
