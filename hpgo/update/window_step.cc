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
                                const StressThresholds& thresholds, const Budget& budget) {
  SubproblemOptions options;
  options.max_iterations = max_iterations;
  options.max_seconds = std::clamp(max_seconds, 0., SubproblemOptions().max_seconds);
  return SolveBy(solver_.get(), options, thresholds, budget);
}

template <typename G>
StepResult WindowStep<G>::SolveBy(SubproblemSolver<G>* solver, SubproblemOptions options,
                                  const StressThresholds& thresholds, const Budget& budget,
                                  const IsKnown& is_known) {
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
    if (!GraphGains(promised, changes)) return result;
  } else {
    if (!ChainsGain(true_cost.value_or(summary.initial_cost), &summary)) return result;
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

// Chains bend on the way. Shortens the step until the cost falls with them linearized where it
// ends; false if it does not, and the poses and the chains are those before it then.
template <typename G>
bool WindowStep<G>::ChainsGain(double cost_before, SubproblemSummary* summary) {
  hierarchy_->TryChains(ChainTrial::kBegin);
  bool gains = !window_.RefreshChains();
  for (int k = 0; k <= kShorterSteps && !gains; ++k) {
    if (k > 0) {
      hierarchy_->TryChains(ChainTrial::kPutBack);
      window_.ShortenStep(kShorterStep);
      window_.RefreshChains();
    }
    const double cost = window_.Cost();
    gains = cost < cost_before;
    if (!gains) continue;
    summary->initial_cost = cost_before;
    summary->final_cost = cost;
    summary->damped |= k > 0;
  }
  if (!gains) {
    hierarchy_->TryChains(ChainTrial::kPutBack);
    window_.TakeBack();
  }
  hierarchy_->TryChains(ChainTrial::kEnd);
  return gains;
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

// What a coarse edge that changes may miss of the pull of those below, in sqrt(chi2): their errors
// turn with it, those they have and those that the step brings.
template <typename G>
double WindowStep<G>::MayMiss(std::size_t k, double change) const {
  const LevelEdge& edge = hierarchy_->level(window_.level()).edges[window_.edges()[k]];
  const G moved = window_.RelativePoseBefore(k).Between(window_.RelativePose(k));
  return 2 * HalfRotation(moved) * (change + std::sqrt(std::max(0.f, edge.chi2)));
}

// Whether the cost of the graph itself falls. Where coarse edges may miss much of what they promise
// those below are asked.
template <typename G>
bool WindowStep<G>::GraphGains(double promised, const std::vector<double>& changes) const {
  const int l = window_.level();
  if (hierarchy_->options().coarse_edges != CoarseEdges::kGalerkin) return true;
  const std::size_t num_edges = window_.edges().size();
  const double most = kShareMissedUnasked * promised;
  std::vector<double> missed(num_edges);
  double sum = 0;
  for (std::size_t k = 0; k < num_edges; ++k) {
    sum += missed[k] = changes[k] * MayMiss(k, changes[k]);
  }
  if (sum < most) return true;
  const auto decrease = [&](double least) {
    int left = kMostAskedBelow;
    double sum_of_all = 0;
    for (std::size_t k = 0; k < num_edges; ++k) {
      int none = 0;
      const bool is_asked = !(missed[k] < least);
      sum_of_all += hierarchy_->CostDecrease(l, window_.edges()[k], window_.RelativePoseBefore(k),
                                             window_.RelativePose(k), is_asked ? &left : &none);
    }
    return sum_of_all;
  };
  const double of_some = decrease(most / num_edges);
  // All of them where those miss more than they may: so may the others.
  return of_some > 0 && (promised - of_some < sum || decrease(0) > 0);
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
    if (l > 0) NoteChanged(l, e, MayMiss(k, change), thresholds, hierarchy_);
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
