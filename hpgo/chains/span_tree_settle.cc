// The tree of spans: where its edges are linearized, and the steps to where they rest.

#include <algorithm>
#include <utility>

#include "hpgo/chains/span_tree.h"
#include "hpgo/hierarchy/coarse_edge.h"

namespace hpgo {
namespace {

// Of a cost, what a step loses that gains nothing any more.
constexpr double kRounding = 1e-9;

// rad, or m per m, by which a span that rests may bend and is not linearized anew: its model misses
// about as much of its cost.
constexpr double kAsGoodAsStraight = 1e-3;

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

// Whether a span is looked into, given the T it should have.
template <typename G>
bool SpanTree<G>::Pass::Concerns(const SpanModel<G>& model, const G& T, bool is_inner) const {
  if (depth == Depth::kFar) return BendAt(model, T) > kFarOnTheWay;
  if (depth == Depth::kLeaves && (is_inner || GainAt(model) > tolerance * tolerance)) return true;
  if (depth == Depth::kMissed && !(BendAt(model, T) > kAsGoodAsStraight)) return false;
  return MissedAt(model, T) > tolerance;
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
void SpanTree<G>::Remember(Index s, LinearizationLog<G>* log) {
  const Span& span = spans_[s];
  log->models.emplace_back(s, Model(s));
  for (int k = 0; k < span.count; ++k) {
    if (span.height > 0) {
      Remember(span.items[k], log);
    } else {
      log->edges.emplace_back(span.items[k], edges_[span.items[k]].Y);
    }
  }
}

template <typename G>
void SpanTree<G>::PutBack(const LogMark& mark, LinearizationLog<G>* log) {
  for (; log->edges.size() > mark.edges; log->edges.pop_back()) {
    const auto& [e, Y] = log->edges.back();
    edges_[e].Y = Y;
  }
  for (; log->models.size() > mark.models; log->models.pop_back()) {
    const auto& [s, model] = log->models.back();
    spans_[s].model = model;
    spans_[s].stale = false;
  }
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

// False where an edge turned further than the reach: the rest was not looked at, and all of it is
// to be undone.
template <typename G>
bool SpanTree<G>::SettleSpan(Index s, const G& T, const Pass& pass, LinearizationLog<G>* log,
                             Settled* settled) {
  Span& span = spans_[s];
  if (!pass.Concerns(Model(s), T, span.height > 0) && s != pass.moved) return true;
  log->models.emplace_back(s, span.model);
  if (span.height == 0) {
    G poses[kLeafEdges];
    DistributeLeaf(span, T, Inside::kMean, poses);
    for (int k = 0; k < span.count; ++k) {
      ChainEdge<G>& edge = edges_[span.items[k]];
      log->edges.emplace_back(span.items[k], edge.Y);
      const typename G::Tangent moved = edge.Y.LocalCoordinates(poses[k]);
      settled->turn = std::max(settled->turn, moved.template tail<G::kRotationDof>().norm());
      edge.Y = poses[k];
    }
    if (settled->turn > pass.reach) return false;
    settled->gained += span.model.cost;
    ComputeLeaf(&span);
    settled->gained -= span.model.cost;
    return true;
  }
  const SplitPose<G> split =
      Distribute(spans_[span.items[0]].model, spans_[span.items[1]].model, T, Inside::kMean);
  if (!SettleSpan(span.items[0], split.first, pass, log, settled) ||
      !SettleSpan(span.items[1], split.second, pass, log, settled)) {
    return false;
  }
  span.model = Join(spans_[span.items[0]].model, spans_[span.items[1]].model, split);
  return true;
}

// Gauss-Newton steps, each from where the last one ended, until an edge turns by less than `still`
// and no model misses more than `tolerance`. The ends go to T in steps within reach. On the way
// spans that hardly bend are taken as they are, so that it costs what bends, not the length of the
// chain; at T all of it is looked at. A step that turns an edge further than a linearization can
// reach is made shorter. Where that does not help the edges are knotted, and the way begins at
// their measurements instead. Bent far enough, steps at T would go anywhere: one that raises the
// cost is the last. `stays`: it lags there already.
template <typename G>
SettleResult SpanTree<G>::GoTo(Index root, const Goal& goal, bool stays, LinearizationLog<G>* log) {
  constexpr int kMaxTurns = 16;  // a half turn in steps within reach, and as many again
  constexpr double kShorter = 0.3, kShortest = 0.02;
  const double tolerance = goal.tolerance;
  SettleResult result;
  double part = 1;
  bool arrived = stays, untied = false;
  Depth depth = stays || tolerance < 0 ? Depth::kLeaves : Depth::kMissed;
  for (int turn = 0; turn < kMaxTurns; ++turn) {
    const StepWithinReach<G> step = TowardsWithinReach(Model(root), goal.T, part);
    Pass pass;
    pass.tolerance = tolerance;
    pass.depth = step.arrives ? depth : Depth::kFar;
    pass.moved = step.arrives ? kNone : root;
    if (!arrived) pass.reach = kReach;
    Settled settled;
    const LogMark before = log->End();
    const bool is_within = SettleSpan(root, step.T, pass, log, &settled);
    const std::size_t num_edges = log->edges.size() - before.edges;
    if (step.arrives && num_edges == 0) return result;
    result.edges += static_cast<int>(num_edges);
    if (arrived && !(settled.gained >= 0)) {
      const Index middle = log->edges[before.edges + num_edges / 2].first;
      PutBack(before, log);
      // More than the model may miss, and so more than rounding: it is out of reach here.
      const double rounding = tolerance > 0 ? tolerance * tolerance : kRounding * Model(root).cost;
      result.holds = settled.gained >= -rounding || !(tolerance > 0 || goal.lags);
      if (!result.holds) unfit_.push_back(edges_[middle].edge);
      return result;
    }
    if (!is_within) {
      PutBack(before, log);
      part *= kShorter;
      if (part > kShortest && !untied) continue;
      if (std::exchange(untied, true)) break;
      Remember(root, log);
      Relax(root);
      part = 1;
      continue;
    }
    for (std::size_t k = before.edges; k < log->edges.size(); ++k) {
      const ChainEdge<G>& edge = edges_[log->edges[k].first];
      if (TurnsTooFar(edge)) unfit_.push_back(edge.edge);
    }
    part = 1;
    const bool comes_from_afar = !step.arrives || (turn > 0 && !arrived);
    const bool moved = settled.turn > goal.still;
    depth = moved || comes_from_afar ? Depth::kLeaves : Depth::kMissed;
    arrived = step.arrives;
    if (tolerance < 0 && !moved && arrived) return result;
  }
  result.holds = arrived;
  return result;
}

template <typename G>
bool SpanTree<G>::FitsTerm(Index root, const G& T) {
  if (IsWithinTerm<G>(ShiftAt(Model(root), T))) return true;
  NameMiddle(root);
  return false;
}

template <typename G>
void SpanTree<G>::NameMiddle(Index root) {
  const Span& span = spans_[root];
  const bool is_leaf = span.height == 0;
  const Index middle = is_leaf ? span.items[span.count / 2] : LastEdge(span.items[0]);
  unfit_.push_back(edges_[middle].edge);
}

// What does not get there stays as it was. It is to be cut, and so is what is bent further than a
// term of its ends can say.
template <typename G>
SettleResult SpanTree<G>::SettleInTurns(Index root, const Goal& goal, LinearizationLog<G>* log) {
  const bool stays = goal.lags && IsLinearizedAt(Model(root), goal.T);
  const LogMark before = log->End();
  const std::size_t unfit_before = unfit_.size();
  SettleResult result = GoTo(root, goal, stays, log);
  if (result.holds) {
    result.holds = FitsTerm(root, goal.T);
    return result;
  }
  if (!stays) PutBack(before, log);
  if (unfit_.size() == unfit_before) NameMiddle(root);
  return result;
}

template <typename G>
SettleResult SpanTree<G>::Settle(Index root, const G& T, double tolerance, bool lags,
                                 LinearizationLog<G>* log) {
  constexpr double kSmallTurn = 0.01;  // rad; what it leaves is of second order
  LinearizationLog<G> own;
  return SettleInTurns(root, {T, tolerance, kSmallTurn, lags}, log != nullptr ? log : &own);
}

template <typename G>
SettleResult SpanTree<G>::SettleAll(Index root, const G& T, bool lags) {
  constexpr double kStill = 1e-8;  // rad
  LinearizationLog<G> log;
  return SettleInTurns(root, {T, -1, kStill, lags}, &log);
}

template class SpanTree<ceres_costs::SE2>;
template class SpanTree<ceres_costs::SE3>;
template class SpanTree<ceres_costs::YawPose>;

}  // namespace hpgo
