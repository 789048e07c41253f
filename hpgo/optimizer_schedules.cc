// Optimizer: which windows an update opens.

#include <algorithm>
#include <cmath>
#include <limits>

#include "hpgo/optimizer_impl.h"

namespace hpgo {

template <typename G>
bool Optimizer<G>::Impl::TopIsSmall() const {
  // Larger only where many components keep the top from shrinking.
  const Level<G>& top = hierarchy_.level(hierarchy_.num_levels() - 1);
  return top.num_nodes / 2 <= options_.max_top_nodes && top.num_edges / 2 <= options_.max_top_edges;
}

// Finds work on a level and does it; 0 if there is none, else how many usual windows it was worth.
template <typename G>
int Optimizer<G>::Impl::ServeStressed(int l) {
  constexpr double kNewShare = 0.2;
  FoundWork work;
  {
    const Stopwatch watch(&report_.examine_seconds);
    work = FindWork(l, options_.max_examined, options_.window_edges, thresholds_, &hierarchy_);
  }
  report_.examined_edges += work.examined;
  if (!work.found) return 0;
  if (l == hierarchy_.num_levels() - 1 && TopIsSmall()) {
    const Stopwatch watch(&report_.top_seconds);
    ++report_.top_solves;
    SolveLevel(l, options_.window_iterations);
    return 1;
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
  SolveWindow(options_.window_iterations);
  const double num_edges = static_cast<double>(window_.edges().size());
  const double seconds_per_edge = watch.Elapsed() / num_edges;
  const double share = seconds_per_edge_ > 0 ? kNewShare : 1;
  seconds_per_edge_ += share * (seconds_per_edge - seconds_per_edge_);
  return std::max(1, static_cast<int>(std::lround(num_edges / options_.window_edges)));
}

// Of the same work, fewer and larger windows carry a correction further: where time is what bounds
// the work they are as large as a part of it allows, and large where nothing does. One that needed
// damping is followed by small ones. A far-off closure bends the whole map, which windows with a
// held border do slowly: for a while those below the top are larger, and count for more.
template <typename G>
WindowLimits Optimizer<G>::Impl::NextWindow(int l) const {
  constexpr double kShareOfTime = 0.34, kFarOff = 3e3;
  double scale = 1;
  if (limits_->max_seconds > 0) {
    const double left = limits_->max_seconds - Seconds(Clock::now() - started_);
    const double seconds = std::min(kShareOfTime * limits_->max_seconds, left);
    const double usual = seconds_per_edge_ * options_.window_edges;
    if (usual > 0) scale = std::clamp(seconds / usual, 1., largest_scale_);
  } else if (refining_) {
    scale = largest_scale_;
  } else if (strain_ > kFarOff && l > 0 && l >= hierarchy_.num_levels() - 2) {
    return {2 * options_.window_nodes, 3 * options_.window_edges};
  }
  return {static_cast<int>(scale * options_.window_nodes),
          static_cast<int>(scale * options_.window_edges)};
}

template <typename G>
void Optimizer<G>::Impl::RunStressSchedule(const UpdateLimits& limits, bool unlimited) {
  started_ = Clock::now();
  SweepLimits sweep;
  sweep.max_windows = unlimited ? std::numeric_limits<int>::max() : options_.max_windows;
  if (unlimited) sweep.max_windows_per_level = std::numeric_limits<int>::max();
  SweepActions actions;
  int previous = hierarchy_.num_levels() - 1;
  actions.serve = [&](int l) {
    // Windows below have moved what this level's edges were made from; as long as they have not
    // been merged again, windows here could undo it.
    if (l > previous) MergeDirtyEdges();
    previous = l;
    return hierarchy_.level(l).dirty.empty() ? ServeStressed(l) : 0;
  };
  actions.largest_pending = [&](int l) { return LargestPending(l, hierarchy_); };
  actions.stop = [&] {
    if (limits.cancel != nullptr && *limits.cancel) return true;
    if (limits.max_seconds <= 0) return false;
    // One window is made at least: else nothing would ever be done in too short a time.
    const bool first = report_.windows + report_.top_solves == 0;
    const double window = first ? 0 : seconds_per_edge_ * options_.window_edges;
    return Seconds(Clock::now() - started_) + window > limits.max_seconds;
  };
  limits_ = &limits;
  report_.at_rest = sweep_.Run(hierarchy_.num_levels(), sweep, 2 * thresholds_.pending, actions);
  // A search that has examined its share may have left some for the next update.
  for (int l = 0; l < hierarchy_.num_levels(); ++l) {
    report_.at_rest &= LargestPending(l, hierarchy_) <= thresholds_.pending;
  }
  limits_ = nullptr;
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
  for (int l = top - 1; l >= 0; --l) {
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
  return {hierarchy_.Ancestor(newest_, l)};
}

template <typename G>
void Optimizer<G>::Impl::SolveFull(const UpdateLimits& limits) {
  constexpr int kMaxIterations = 50;
  const Stopwatch watch(&report_.window_seconds);
  limits_ = &limits;
  if (window_.BuildWhole(0, &hierarchy_)) {
    ++report_.windows;
    SolveWindow(kMaxIterations);
  }
  limits_ = nullptr;
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
