#include "hpgo/update/window_step.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/solve/solver_factory.h"
#include "hpgo/update/constants.h"
#include "hpgo/update/graph_decrease.h"
#include "hpgo/update/motion.h"
#include "hpgo/update/news.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

// What the model of a step missed, or what the step leaves by it. One that gains more than it
// promised, as past the bend of a loss, had a model that is c times too stiff: it promised p,
// gained (2 - 1 / c) p, and there was c p.
double Missed(double promised, double gained) {
  const double missed = std::abs(promised - gained);
  if (!(gained > promised)) return missed;
  const double left = promised / std::max(2 - gained / promised, 1 / kMostTooStiff) - gained;
  return std::max(missed, left);
}

}  // namespace

void Note(const StepResult& step, UpdateReport* report) {
  if (!step.status.ok()) report->status = step.status;
  report->solved_nodes += step.solved_nodes;
  report->cost_decrease += step.decrease;
  report->largest_moved = Larger(report->largest_moved, step.largest_moved);
}

template <typename G>
WindowStep<G>::WindowStep(Engine engine, Hierarchy<G>* hierarchy, LevelEdgeNamer name)
    : hierarchy_(hierarchy), name_(std::move(name)), solver_(MakeSolver<G>(engine)) {}

template <typename G>
StepResult WindowStep<G>::Solve(int max_iterations, double max_seconds,
                                const StressThresholds& thresholds, const Budget& budget,
                                const SeenCost<G>& seen) {
  SubproblemOptions options;
  options.max_iterations = max_iterations;
  options.max_seconds = std::clamp(max_seconds, 0., SubproblemOptions().max_seconds);
  return SolveBy(solver_.get(), options, thresholds, budget, {}, seen);
}

template <typename G>
StepResult WindowStep<G>::SolveBy(SubproblemSolver<G>* solver, SubproblemOptions options,
                                  const StressThresholds& thresholds, const Budget& budget,
                                  const IsKnown& is_known, const SeenCost<G>& seen) {
  options.cancel = budget.cancel();
  std::optional<double> true_cost;  // where the solver does not know it
  if (window_.Lags()) true_cost = window_.Cost();
  SubproblemSummary summary = solver->Solve(options, &window_.subproblem());
  VLOG(2) << "window: level " << window_.level() << ", " << window_.num_free() << " nodes, "
          << window_.edges().size() << " edges, cost " << summary.initial_cost << " -> "
          << summary.final_cost << (summary.damped ? ", damped, " : ", ") << summary.seconds * 1e3
          << " ms";
  StepResult result;
  result.initial_cost = summary.initial_cost;
  result.solved_nodes = window_.num_free();
  result.converged = summary.converged;
  result.damped = summary.damped;
  const bool usable = summary.status.ok() || summary.status.code() == StatusCode::kInterrupted;
  if (!usable) result.status = WhyUnusable(summary.status);
  const double promised = summary.initial_cost - summary.final_cost;
  if (!usable || !(promised > 0)) return result;
  std::vector<double> changes;
  if (window_.level() > 0) {
    changes = Changes();
    if (!IsTaken(GraphGain(promised, changes, seen), seen, &result)) return result;
  } else {
    const double cost_before = true_cost.value_or(summary.initial_cost);
    if (!ChainsGain(cost_before, seen, &summary, &result)) return result;
    changes = Changes();
  }
  result.largest_moved = LargestMoved();
  result.damped = summary.damped;
  result.decrease = summary.initial_cost - summary.final_cost;
  result.missed = Missed(summary.predicted_decrease, result.decrease);
  const bool gains = result.decrease > thresholds.tau;
  const bool misses = summary.damped || result.missed > kTausMissedForAnother * thresholds.tau;
  result.is_nonlinear = gains && misses;
  double left_behind = misses ? std::sqrt(result.missed / window_.edges().size()) : 0;
  // A damped step leaves stress behind; worth another look as long as it got somewhere.
  if (summary.damped && gains) left_behind = std::max<double>(left_behind, 2 * thresholds.pending);
  Take(changes, left_behind, thresholds, is_known);
  return result;
}

template <typename G>
void WindowStep<G>::Take(double left_behind, const StressThresholds& thresholds) {
  Take(Changes(), left_behind, thresholds, {});
}

template <typename G>
void WindowStep<G>::Take(const std::vector<double>& changes, double left_behind,
                         const StressThresholds& thresholds, const IsKnown& is_known) {
  window_.Commit(hierarchy_);
  QueueRefreshed(thresholds, hierarchy_);
  RecordChanges(changes, left_behind, thresholds, is_known);
}

// Whether a step is taken that gains so much.
template <typename G>
bool WindowStep<G>::IsTaken(double gained, const SeenCost<G>& seen, StepResult* result) const {
  if (!(gained > 0)) return false;
  result->is_seen_to_rise = !seen.may_rise && !(gained + SeenAside(seen, window_, *hierarchy_) > 0);
  return !result->is_seen_to_rise;
}

// Chains bend on the way. Shortens the step until the cost falls with them linearized where it
// ends; false if it does not, and the poses and the chains are those before it then.
template <typename G>
bool WindowStep<G>::ChainsGain(double cost_before, const SeenCost<G>& seen,
                               SubproblemSummary* summary, StepResult* result) {
  hierarchy_->TryChains(ChainTrial::kBegin);
  double cost = window_.RefreshChains() ? window_.Cost() : summary->final_cost;
  bool is_taken = IsTaken(cost_before - cost, seen, result);
  int shorter = 0;
  for (; shorter < kShorterSteps && !is_taken; ++shorter) {
    hierarchy_->TryChains(ChainTrial::kPutBack);
    window_.ShortenStep(kShorterStep);
    window_.RefreshChains();
    cost = window_.Cost();
    is_taken = IsTaken(cost_before - cost, seen, result);
  }
  if (is_taken) {
    summary->initial_cost = cost_before;
    summary->final_cost = cost;
    summary->damped |= shorter > 0;
  } else {
    hierarchy_->TryChains(ChainTrial::kPutBack);
    window_.TakeBack();
  }
  hierarchy_->TryChains(ChainTrial::kEnd);
  return is_taken;
}

// By how much each edge pulls otherwise, in sqrt(chi2), after the step.
template <typename G>
std::vector<double> WindowStep<G>::Changes() const {
  const int l = window_.level();
  std::vector<double> changes(window_.edges().size());
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const Index e = window_.edges()[k];
    const bool unary = hierarchy_->level(l).edges[e].node[0] == kNone;
    changes[k] = FactorChange(hierarchy_->FactorOf(l, e), unary, window_.RelativePoseBefore(k),
                              window_.RelativePose(k));
  }
  return changes;
}

// By how much the cost of the graph itself falls. Condensed edges do not say what it costs: their
// steps are taken as the paper does, where it may rise.
template <typename G>
double WindowStep<G>::GraphGain(double promised, const std::vector<double>& changes,
                                const SeenCost<G>& seen) const {
  const bool is_condensed = hierarchy_->options().coarse_edges == CoarseEdges::kCondensed;
  if (is_condensed && seen.may_rise) return promised;
  const Asking asking = seen.may_rise ? Asking::kWhereInDoubt : Asking::kAll;
  return GraphDecrease(window_, promised, changes, *hierarchy_, asking);
}

template <typename G>
Motion WindowStep<G>::LargestMoved() const {
  double distance_sq = 0, half_rotation = 0;
  G most_turned;
  for (int k = 0; k < window_.num_free(); ++k) {
    const G moved = window_.Moved(k);
    distance_sq = std::max(distance_sq, moved.translation().squaredNorm());
    if (HalfRotation(moved) <= half_rotation) continue;
    half_rotation = HalfRotation(moved);
    most_turned = moved;
  }
  return {std::sqrt(distance_sq), Angle(most_turned)};
}

template <typename G>
Status WindowStep<G>::NotFinite(Index level_edge) const {
  return Status(StatusCode::kNoSolution,
                name_(level_edge) + ": its cost cannot be evaluated at the estimate");
}

// The edge at fault if there is one, else what the solver says.
template <typename G>
Status WindowStep<G>::WhyUnusable(const Status& status) const {
  for (std::size_t k = 0; k < window_.edges().size() && window_.level() == 0; ++k) {
    const Index e = window_.edges()[k];
    const bool unary = hierarchy_->level(0).edges[e].node[0] == kNone;
    if (!std::isfinite(
            FactorCost(hierarchy_->FactorOf(0, e), unary, window_.RelativePoseBefore(k)))) {
      return NotFinite(e);
    }
  }
  return status;
}

// `left_behind`: the pending of an edge between free nodes after the step.
template <typename G>
void WindowStep<G>::RecordChanges(const std::vector<double>& changes, double left_behind,
                                  const StressThresholds& thresholds, const IsKnown& is_known) {
  const int l = window_.level();
  for (std::size_t k = 0; k < window_.edges().size(); ++k) {
    const Index e = window_.edges()[k];
    const LevelEdge& edge = hierarchy_->level(l).edges[e];
    const double change = changes[k];
    TellParent(l, e, change, thresholds, hierarchy_);
    // Step by step it turns away from where it was merged.
    if (l > 0) {
      const double missed =
          MissedPull(edge, window_.RelativePoseBefore(k), window_.RelativePose(k), change);
      NoteChanged(l, e, missed, thresholds, hierarchy_);
    }
    if (window_.IsInterior(k) && (!is_known || is_known(e))) {
      HandDown(l, e, edge.pending + change, thresholds, hierarchy_);
      const double pending = is_known ? std::max<double>(edge.pending, left_behind) : left_behind;
      hierarchy_->SetPending(l, e, static_cast<float>(pending), thresholds.pending);
    } else {
      AddPending(l, e, change, thresholds, hierarchy_);
    }
  }
}

template class WindowStep<SE2>;
template class WindowStep<SE3>;
template class WindowStep<YawPose>;

}  // namespace hpgo
