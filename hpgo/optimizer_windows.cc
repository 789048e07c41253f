// Optimizer: the solve of a window, and what follows from it.

#include <algorithm>
#include <cmath>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/damping.h"

namespace hpgo {
namespace {

// Grows with the angle; about half of it where it is small.
double HalfRotation(const SE2& T) { return 0.5 * std::abs(T.angle()); }
double HalfRotation(const SE3& T) { return T.rotation().vec().norm(); }

double Angle(const SE2& T) { return std::abs(T.angle()); }
double Angle(const SE3& T) { return 2 * std::asin(std::min(1., T.rotation().vec().norm())); }

}  // namespace

template <typename G>
void Optimizer<G>::Impl::SolveLevel(int l, int iterations) {
  if (!window_.BuildWhole(l, &hierarchy_)) return;
  SolveWindow(iterations);
}

// Solves the window on level 0 again as long as its last step was far from linear: until it gains
// nothing that counts. Returns the number of solves.
template <typename G>
int Optimizer<G>::Impl::SolveWindowToRest(int max_solves) {
  int solves = 1;
  while (SolveWindow(options_.window_iterations) && window_.level() == 0 && solves < max_solves &&
         !IsStopped()) {
    window_.Restart();
    ++solves;
  }
  return solves;
}

// Solves the window and takes the result if the cost has fallen. True if the step missed what its
// linearization promised by so much that another is worth it.
template <typename G>
bool Optimizer<G>::Impl::SolveWindow(int max_iterations, double max_seconds) {
  constexpr double kLargestScale = 20, kScaleGrowth = 1.5;
  constexpr int kMoreIterations = 5;
  SubproblemOptions options;
  options.cancel = limits_.cancel;
  const auto solve = [&](int iterations, double seconds) {
    options.max_iterations = iterations;
    options.max_seconds = std::clamp(seconds, 0., SubproblemOptions().max_seconds);
    report_.solved_nodes += window_.subproblem().num_free;
    return solver_->Solve(options, &window_.subproblem());
  };
  SubproblemSummary summary = solve(max_iterations, max_seconds);
  damped_ |= summary.damped;
  VLOG(2) << "window: level " << window_.level() << ", " << window_.num_free() << " nodes, "
          << window_.edges().size() << " edges, cost " << summary.initial_cost << " -> "
          << summary.final_cost << (summary.damped ? ", damped, " : ", ") << summary.seconds * 1e3
          << " ms";
  converged_ = summary.converged;
  const double seconds_for_more = SecondsForWindow() - summary.seconds;
  if (window_.level() == 0 && IsStrained() && max_iterations < kMoreIterations && summary.damped &&
      summary.status.ok() && summary.final_cost < summary.initial_cost &&
      seconds_for_more > summary.seconds) {
    // Bent so far, a window goes a short way with a step. On coarse levels this would only leave
    // the range where their edges hold.
    const SubproblemSummary more = solve(kMoreIterations, seconds_for_more);
    if (more.status.code() != StatusCode::kNoSolution) {
      summary.final_cost = more.final_cost;
      summary.predicted_decrease += more.predicted_decrease;
    }
  }
  largest_scale_ = summary.damped ? 1 : std::min(kLargestScale, kScaleGrowth * largest_scale_);
  const bool usable = summary.status.ok() || summary.status.code() == StatusCode::kInterrupted;
  if (!usable) report_.status = WhyUnusable(summary.status);
  if (!usable || !(summary.final_cost < summary.initial_cost) || !GraphGains()) return false;
  if (window_.RefreshChains() && !ShortenToGain(&summary)) return false;
  double stretch = 1;
  // What the windows of one update can take in needs no more than the solution.
  if (window_.level() > 0 && IsStrained() && !rested_ && !summary.damped) {
    stretch = over_correction_.Factor(window_, hierarchy_);
    if (stretch > 1) window_.Stretch(stretch);
  }
  window_.Commit(&hierarchy_);
  NoteRefreshed();
  NoteMotions();
  report_.cost_decrease += (summary.initial_cost - summary.final_cost) * stretch * (2 - stretch);
  RecordChanges(summary, stretch);
  const double decrease = summary.initial_cost - summary.final_cost;
  const double miss = std::abs(summary.predicted_decrease - decrease);
  return decrease > thresholds_.tau && (summary.damped || miss > 10 * thresholds_.tau);
}

// Chains bend on the way: shortens the step until the cost falls with them linearized where it
// ends. False if it does not; the poses are those before the step then.
template <typename G>
bool Optimizer<G>::Impl::ShortenToGain(SubproblemSummary* summary) {
  constexpr double kShortest = 1e-3, kMostOfIt = 0.5, kLeastOfIt = 0.1;
  double promised = summary->initial_cost - summary->final_cost;
  for (double part = 1; part > kShortest;) {
    const double cost = window_.Cost();
    if (cost < summary->initial_cost) {
      summary->damped |= part < 1;
      summary->final_cost = cost;
      return true;
    }
    const double length = BestStepLength(promised, cost - summary->initial_cost);
    const double shorter = length > kLeastOfIt ? std::min(length, kMostOfIt) : kLeastOfIt;
    part *= shorter;
    promised *= 2 * shorter - shorter * shorter;
    window_.Stretch(shorter);
    window_.RefreshChains();
  }
  window_.Stretch(0);
  window_.RefreshChains();
  return false;
}

// Whether the cost of the graph itself falls. A coarse edge says little about far turns, least of
// all where the edges it stands for are stretched.
template <typename G>
bool Optimizer<G>::Impl::GraphGains() const {
  constexpr double kFar = 0.025;        // half radians; nearer, all levels agree
  constexpr int kMostEvaluated = 2000;  // edges of the levels below
  const int l = window_.level();
  if (l == 0 || options_.coarse_edges != CoarseEdges::kGalerkin) return true;
  const auto is_far = [&](std::size_t k) {
    return !(HalfRotation(window_.RelativePoseBefore(k).Between(window_.RelativePose(k))) < kFar);
  };
  const std::size_t num_edges = window_.edges().size();
  std::size_t first_far = 0;
  while (first_far < num_edges && !is_far(first_far)) ++first_far;
  if (first_far == num_edges) return true;
  int budget = kMostEvaluated;
  double decrease = 0;
  for (std::size_t k = 0; k < num_edges; ++k) {
    int none = 0;
    decrease += hierarchy_.CostDecrease(l, window_.edges()[k], window_.RelativePoseBefore(k),
                                        window_.RelativePose(k), is_far(k) ? &budget : &none);
  }
  return decrease > 0;
}

template <typename G>
Motion Optimizer<G>::Impl::MotionBetween(const G& before, const G& after) {
  const G moved = before.Between(after);
  return {moved.translation().norm(), Angle(moved)};
}

template <typename G>
void Optimizer<G>::Impl::NoteMotions() {
  double distance_sq = 0, half_rotation = 0;
  G most_turned;
  for (int k = 0; k < window_.subproblem().num_free; ++k) {
    const G moved = window_.Moved(k);
    distance_sq = std::max(distance_sq, moved.translation().squaredNorm());
    if (HalfRotation(moved) <= half_rotation) continue;
    half_rotation = HalfRotation(moved);
    most_turned = moved;
  }
  Motion& largest = report_.largest_moved;
  largest.distance = std::max(largest.distance, std::sqrt(distance_sq));
  largest.angle = std::max(largest.angle, Angle(most_turned));
}

template <typename G>
Status Optimizer<G>::Impl::NotFinite(Index level_edge) const {
  return Status(StatusCode::kNoSolution,
                NameOfLevelEdge(level_edge) + ": its cost cannot be evaluated at the estimate");
}

// The edge at fault if there is one, else what the solver says.
template <typename G>
Status Optimizer<G>::Impl::WhyUnusable(const Status& status) {
  for (std::size_t k = 0; k < window_.edges().size() && window_.level() == 0; ++k) {
    const Index e = window_.edges()[k];
    const bool unary = hierarchy_.level(0).edges[e].node[0] == kNone;
    if (!std::isfinite(
            FactorCost(hierarchy_.FactorOf(0, e), unary, window_.RelativePoseBefore(k)))) {
      return NotFinite(e);
    }
  }
  return status;
}

template <typename G>
void Optimizer<G>::Impl::RecordChanges(const SubproblemSummary& summary, double stretch) {
  const int l = window_.level();
  const double miss =
      std::abs(summary.predicted_decrease - (summary.initial_cost - summary.final_cost));
  const bool nonlinear = summary.damped || miss > 10 * thresholds_.tau;
  double unexplained = nonlinear ? std::sqrt(miss / window_.edges().size()) : 0;
  // A damped step leaves stress behind; worth another look as long as it got somewhere.
  if (summary.damped && summary.initial_cost - summary.final_cost > thresholds_.tau) {
    unexplained = std::max<double>(unexplained, 2 * thresholds_.pending);
  }
  Level<G>& level = hierarchy_.mutable_level(l);
  for (std::size_t k = 0; k < window_.edges().size(); ++k) {
    const Index e = window_.edges()[k];
    LevelEdge& edge = level.edges[e];
    const ceres_costs::FactorTerm<G>& factor = window_.subproblem().factors[k];
    const bool unary = edge.node[0] == kNone;
    const double change =
        FactorChange(factor, unary, window_.RelativePoseBefore(k), window_.RelativePose(k));
    TellParent(l, e, change, thresholds_, &hierarchy_);
    if (window_.IsInterior(k)) {
      HandDown(l, e, edge.pending + change, thresholds_, &hierarchy_);
      // The part of a motion that is beyond the solution is to be looked at again.
      const double beyond = (1 - 1 / stretch) * change;
      hierarchy_.SetPending(l, e, static_cast<float>(std::max(unexplained, beyond)),
                            thresholds_.pending);
    } else {
      AddPending(l, e, change, thresholds_, &hierarchy_);
    }
  }
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
