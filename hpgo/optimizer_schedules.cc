// Optimizer: which windows an update opens.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "hpgo/optimizer_impl.h"

namespace hpgo {
namespace {

// The time of a window grows with this power of its size: the factorization fills in.
constexpr double kFillGrowth = 1.3;
constexpr double kShareOfTime = 0.35;  // of a limit, for a window

}  // namespace

template <typename G>
bool Optimizer<G>::Impl::TopIsSmall() const {
  // Larger only where many components keep the top from shrinking.
  return !hierarchy_.IsTooLarge(hierarchy_.num_levels() - 1, 2);
}

template <typename G>
double Optimizer<G>::Impl::SecondsLeft() const {
  double left = std::numeric_limits<double>::infinity();
  if (limits_.max_seconds > 0) left = limits_.max_seconds - Seconds(Clock::now() - started_);
  if (limits_.max_cpu_seconds > 0) {
    left = std::min(left, limits_.max_cpu_seconds - (ThreadCpuSeconds() - cpu_started_));
  }
  return left;
}

// Infinity without a limit.
template <typename G>
double Optimizer<G>::Impl::SecondsForWindow() const {
  return std::min(kShareOfTime * TimeLimit(), SecondsLeft());
}

template <typename G>
bool Optimizer<G>::Impl::IsStopped() const {
  return (limits_.cancel != nullptr && *limits_.cancel) || SecondsLeft() < 0;
}

// Whether a far-off closure is being taken in.
template <typename G>
bool Optimizer<G>::Impl::IsStrained() const {
  return options_.schedule == Schedule::kStress && strain_ > kFarOff;
}

// Whether that happens at the default cap, and steps are too long for it: until they are not,
// updates are larger.
template <typename G>
bool Optimizer<G>::Impl::Struggles() const {
  return IsStrained() && damped_last_ && !IsUncapped();
}

// Finds work on a level and does it; 0 if there is none, else how many usual windows it was worth.
template <typename G>
int Optimizer<G>::Impl::ServeStressed(int l, int max_solves) {
  FoundWork work;
  {
    const Stopwatch watch(&report_.examine_seconds);
    do {
      work = FindWork(l, options_.max_examined, options_.window_edges, thresholds_, &hierarchy_);
      report_.examined_edges += work.examined;
    } while (!work.found && IsUncapped() && !IsStopped() &&
             LargestPending(l, hierarchy_) > thresholds_.pending);
  }
  if (!work.found) return 0;
  if (l == hierarchy_.num_levels() - 1 && TopIsSmall()) {
    const Stopwatch watch(&report_.top_seconds);
    ++report_.top_solves;
    if (!window_.BuildWhole(l, &hierarchy_)) return 1;
    const int solves = SolveWindowToRest(max_solves);
    LearnWindowSeconds(watch.Elapsed() / solves);
    return solves;
  }
  const Stopwatch watch(&report_.window_seconds);
  std::vector<Index> seeds;
  for (const Index end : work.ends) {
    if (end != kNone) seeds.push_back(end);
  }
  // Near a new edge, all of its ends' ancestors belong into the window.
  const std::vector<Index>& fresh = seeds_[l];
  const bool near = std::any_of(seeds.begin(), seeds.end(), [&](Index n) {
    return std::find(fresh.begin(), fresh.end(), n) != fresh.end();
  });
  if (near && !had_window_[l]) seeds.insert(seeds.end(), fresh.begin(), fresh.end());
  had_window_[l] = true;
  ++report_.windows;
  if (!window_.Build(l, seeds, NextWindow(l), &hierarchy_)) return 1;
  const int solves = SolveWindowToRest(max_solves);
  LearnWindowSeconds(watch.Elapsed() / solves);
  return std::max(1, static_cast<int>(std::lround(solves * Worth())));
}

// How many windows of the options' size the last one is.
template <typename G>
double Optimizer<G>::Impl::Worth() {
  return std::max(static_cast<double>(window_.edges().size()) / options_.window_edges,
                  static_cast<double>(window_.subproblem().num_free) / options_.window_nodes);
}

// Small windows say little about large ones.
template <typename G>
void Optimizer<G>::Impl::LearnWindowSeconds(double elapsed) {
  constexpr double kSmall = 0.5;
  // Rather too small a window than an update that takes too long.
  constexpr double kShareOfFaster = 0.2, kShareOfSlower = 0.5;
  if (Worth() < kSmall) return;
  const double seconds = elapsed / std::pow(Worth(), kFillGrowth);
  double& mean = window_seconds_[window_.level()];
  const double share = mean == 0 ? 1 : seconds > mean ? kShareOfSlower : kShareOfFaster;
  mean += share * (seconds - mean);
}

// What a window of the options' size takes on a level, by recent ones there or, where there was
// none yet, on the slowest level; 0 without any.
template <typename G>
double Optimizer<G>::Impl::UsualWindowSeconds(int l) const {
  const double own = window_seconds_[l];
  return own > 0 ? own : *std::max_element(window_seconds_.begin(), window_seconds_.end());
}

// Of the same work, fewer and larger windows carry a correction further: where time is what bounds
// the work they are as large as a part of it allows, and large where nothing does. One that needed
// damping is followed by small ones. A far-off closure bends the whole map, which windows with a
// held border do slowly: for a while those below the top are larger, and count for more.
template <typename G>
WindowLimits Optimizer<G>::Impl::NextWindow(int l) const {
  double nodes_scale = 1, edges_scale = 1;
  if (HasTimeLimit()) {
    const double seconds = SecondsForWindow();
    const double usual = UsualWindowSeconds(l);
    if (usual > 0 && seconds > usual) {
      nodes_scale = edges_scale =
          std::min(std::pow(seconds / usual, 1 / kFillGrowth), largest_scale_);
    }
  } else if (refining_) {
    nodes_scale = edges_scale = largest_scale_;
  } else if (IsStrained() && l > 0 && l >= hierarchy_.num_levels() - 2) {
    nodes_scale = 2;
    edges_scale = 3;
  }
  const auto scaled = [](int count, double scale) {
    return static_cast<int>(std::min<double>(scale * count, std::numeric_limits<int>::max()));
  };
  return {scaled(options_.window_nodes, nodes_scale), scaled(options_.window_edges, edges_scale)};
}

template <typename G>
void Optimizer<G>::Impl::RunStressSchedule() {
  window_seconds_.resize(hierarchy_.num_levels());
  SweepLimits sweep;
  sweep.max_windows = options_.max_windows;
  if (HasTimeLimit()) {
    sweep.max_windows = sweep.max_windows_per_level = std::numeric_limits<int>::max();
    // Level 0 takes the most windows to cover.
    sweep.max_bottom_windows = 6;
  } else if (Struggles()) {
    sweep.max_windows = 2 * std::min(sweep.max_windows, std::numeric_limits<int>::max() / 2);
    sweep.max_windows_per_level *= 2;
  }
  SweepActions actions;
  int previous = hierarchy_.num_levels() - 1;
  const auto stop = [&](int l) {
    // One window is made at least: else nothing would ever be done in too short a time.
    if (report_.windows + report_.top_solves == 0) {
      return limits_.cancel != nullptr && *limits_.cancel;
    }
    return IsStopped() || (LargestPending(l, hierarchy_) > thresholds_.pending &&
                           SecondsLeft() < UsualWindowSeconds(l));
  };
  actions.stop = stop;
  int solves = 0;
  actions.serve = [&](int l) {
    // Windows below have moved what this level's edges were made from; as long as they have not
    // been merged again, windows here could undo it.
    if (l > std::exchange(previous, l)) {
      MergeDirtyEdges();
      if (stop(l)) return 0;
    }
    if (!hierarchy_.level(l).dirty.empty()) return 0;
    const int worth = ServeStressed(l, std::max(1, sweep.max_windows - solves));
    solves += worth;
    return worth;
  };
  actions.largest_pending = [&](int l) { return LargestPending(l, hierarchy_); };
  report_.at_rest = sweep_.Run(hierarchy_.num_levels(), sweep, 2 * thresholds_.pending, actions);
  report_.at_rest &= !graph_.has_changes();  // a chain that must not stay one
  // A search or a merge that has done its share may have left some for the next update.
  for (int l = 0; l < hierarchy_.num_levels(); ++l) {
    report_.at_rest &= LargestPending(l, hierarchy_) <= thresholds_.pending;
    report_.at_rest &= hierarchy_.level(l).dirty.empty();
  }
}

// The whole top, and a window on every lower level, whether it is stressed or not.
template <typename G>
void Optimizer<G>::Impl::RunFixedSchedule() {
  const int top = hierarchy_.num_levels() - 1;
  {
    const Stopwatch watch(&report_.top_seconds);
    ++report_.top_solves;
    SolveLevel(top, options_.window_iterations);
  }
  const Stopwatch watch(&report_.window_seconds);
  for (int l = top - 1; l >= 0 && !IsStopped(); --l) {
    const std::vector<Index> seeds = SeedsOnLevel(l);
    if (window_.Build(l, seeds, {options_.window_nodes, options_.window_edges}, &hierarchy_)) {
      ++report_.windows;
      SolveWindow(options_.window_iterations);
    }
  }
}

template <typename G>
std::vector<Index> Optimizer<G>::Impl::SeedsOnLevel(int l) const {
  if (options_.schedule == Schedule::kNewEdges) return seeds_[l];
  if (newest_ == kNone) return {};
  return {hierarchy_.Ancestor(graph_.LevelNodeOf(newest_), l)};
}

template <typename G>
void Optimizer<G>::Impl::SolveFull() {
  constexpr int kMaxIterations = 50;
  // Chains are linearized in turns with the solve of what is between them.
  constexpr int kMaxTurns = 20;
  constexpr double kStill = 1e-10;  // of the cost
  const Stopwatch watch(&report_.window_seconds);
  for (int turn = 0; turn < kMaxTurns && !IsStopped(); ++turn) {
    if (turn > 0) graph_.SettleAll();
    if (!window_.BuildWhole(0, &hierarchy_)) return;
    ++report_.windows;
    const double before = report_.cost_decrease;
    SolveWindow(kMaxIterations, SecondsLeft());
    if (!report_.status.ok() || report_.cost_decrease - before <= kStill * Cost()) return;
  }
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
