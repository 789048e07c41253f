// Optimizer: the steps of an update before anything is solved.

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/solver_factory.h"

namespace hpgo {

template <typename G>
Optimizer<G>::Impl::Impl(const OptimizerOptions& options)
    : options_(options),
      graph_({options.max_group_size, options.max_top_nodes, options.max_whole_nodes,
              options.max_top_edges, options.coarse_edges, options.convention},
             options.condense_chains),
      hierarchy_(graph_.hierarchy()),
      solver_(MakeSolver<G>(options.engine)) {}

template <typename G>
UpdateReport Optimizer<G>::Impl::Update(Mode mode, const UpdateLimits& limits) {
  depth_ = 1;
  at_optimum_ = false;
  return Step(mode, limits);
}

template <typename G>
UpdateReport Optimizer<G>::Impl::Step(Mode mode, const UpdateLimits& limits) {
  rested_ = report_.at_rest;
  report_ = UpdateReport();
  limits_ = limits;
  started_ = Clock::now();
  if (limits.max_cpu_seconds > 0) cpu_started_ = ThreadCpuSeconds();
  damped_last_ = std::exchange(damped_, false);
  G newest_before;
  {
    const Stopwatch total(&report_.seconds);
    InsertNewNodes();
    newest_before = NewestPose();
    if (depth_ == 1) SampleChi2();  // else Refine has measured it
    SetThresholds();
    NoteNewEdges();
    MergeDirtyEdges();
    if (mode == Mode::kFull) {
      SolveFull();
    } else if (mode == Mode::kTop) {
      SolveLevel(hierarchy_.num_levels() - 1, options_.window_iterations);
    } else if (options_.schedule == Schedule::kStress) {
      RunStressSchedule();
    } else {
      RunFixedSchedule();
    }
    new_edges_.clear();
    limits_ = UpdateLimits();
  }
  report_.num_levels = hierarchy_.num_levels();
  report_.newest_moved = MotionBetween(newest_before, NewestPose());
  Motion& largest = report_.largest_moved;  // of single solves so far
  largest.distance = std::max(largest.distance, report_.newest_moved.distance);
  largest.angle = std::max(largest.angle, report_.newest_moved.angle);
  VLOG(1) << "update: " << report_.new_nodes << " nodes, " << report_.new_edges << " edges, "
          << report_.windows << " windows, " << report_.top_solves << " top solves, "
          << report_.seconds * 1e3 << " ms";
  return report_;
}

template <typename G>
void Optimizer<G>::Impl::InsertNewNodes() {
  const Stopwatch watch(&report_.insert_seconds);
  report_.new_nodes = static_cast<int>(new_nodes_.size());
  report_.new_edges = static_cast<int>(new_edges_.size());
  if (check_anchors_) AlignJoinedComponents();
  graph_.Restructure();
  check_anchors_ |= graph_.has_new_component();
  hierarchy_.AssignGroups();
  if (check_anchors_) HoldComponents();
  check_anchors_ = false;
  new_nodes_.clear();
}

// A few edges an update, spread over the graph: the mean must follow the estimate, and no update
// may look at all of them.
template <typename G>
void Optimizer<G>::Impl::SampleChi2() {
  constexpr int kPerUpdate = 4, kMostPerUpdate = 1000, kMemory = 2000;
  constexpr std::uint32_t kStride = 2654435761u;  // of the golden ratio
  // One edge that does not fit yet says nothing about the noise.
  constexpr double kOutlier = 10;
  const Level<G>& level = hierarchy_.level(0);
  if (level.num_edges == 0) return;
  const int count = std::min(kPerUpdate + report_.new_edges, kMostPerUpdate);
  for (int k = 0; k < count; ++k) {
    next_sample_ += kStride;
    const Index e = static_cast<Index>((std::uint64_t{next_sample_} * level.edges.size()) >> 32);
    const LevelEdge& edge = level.edges[e];
    if (!edge.alive || !edge.merged) continue;
    double chi2 = FactorCost(hierarchy_.FactorOf(0, e), edge.node[0] == kNone,
                             hierarchy_.RelativePose(0, edge.node[0], edge.node[1]));
    if (!std::isfinite(chi2)) continue;
    chi2 = std::min(chi2, std::max<double>(G::kDof, kOutlier * mean_chi2_));
    num_samples_ = std::min(num_samples_ + 1, kMemory);
    mean_chi2_ += (chi2 - mean_chi2_) / num_samples_;
  }
}

template <typename G>
void Optimizer<G>::Impl::SetThresholds() {
  report_.mean_chi2 = mean_chi2_;
  thresholds_ = StressThresholds::FromMean(mean_chi2_, options_.stress_threshold / depth_);
  graph_.SetTolerance(0.2 * thresholds_.dirty);
  if (options_.schedule != Schedule::kStress) {
    thresholds_.pending = std::numeric_limits<float>::infinity();  // nobody will look
  }
  // Condensed edges hold measurements. Made anew whenever members move within their groups, they
  // would pull the groups back while the windows push the members on, without end.
  if (options_.coarse_edges == CoarseEdges::kCondensed) {
    thresholds_.dirty = std::numeric_limits<float>::infinity();
  }
}

template <typename G>
void Optimizer<G>::Impl::NoteNewEdges() {
  constexpr double kFading = 0.97, kMostStrain = 10 * kFarOff;
  const Stopwatch watch(&report_.insert_seconds);
  strain_ *= kFading;
  const int num_levels = hierarchy_.num_levels();
  seeds_.resize(num_levels);
  for (std::vector<Index>& seeds : seeds_) seeds.clear();
  had_window_.assign(num_levels, false);
  Level<G>& level = hierarchy_.mutable_level(0);
  std::vector<Index> fresh;
  for (const PlacedEdge& placed : graph_.placed()) {
    level.edges[placed.edge].merged = true;
    if (placed.is_new) {
      fresh.push_back(placed.edge);
    } else {
      // What was there in another form: the look decides.
      hierarchy_.SetPending(0, placed.edge, 2 * thresholds_.pending, thresholds_.pending);
    }
  }
  for (const EdgeId id : new_edges_) {
    const Result<Index> found = FindEdge(id);
    if (!found.ok()) continue;  // removed since
    const Index e = graph_.LevelEdgeOf(*found);
    if (e != kNone) fresh.push_back(e);
  }
  std::sort(fresh.begin(), fresh.end());
  fresh.erase(std::unique(fresh.begin(), fresh.end()), fresh.end());
  for (const Index e : fresh) {
    const LevelEdge& edge = level.edges[e];
    const double chi2 = FactorCost(hierarchy_.FactorOf(0, e), edge.node[0] == kNone,
                                   hierarchy_.RelativePose(0, edge.node[0], edge.node[1]));
    if (!std::isfinite(chi2)) {
      report_.status = NotFinite(e);
      continue;
    }
    if (mean_chi2_ > 0) strain_ = std::min(strain_ + chi2 / mean_chi2_, kMostStrain);
    // Taken in by a small part of the map it would bend that beyond what rigid groups can
    // straighten.
    if (chi2 > kFarOff * mean_chi2_) {
      sweep_.StartAtTop();
      over_correction_.Forget();
    }
    AddPending(0, e, std::sqrt(chi2), thresholds_, &hierarchy_);
    for (Index end : edge.node) {
      for (int l = 0; l < num_levels && end != kNone; ++l) {
        std::vector<Index>& seeds = seeds_[l];
        if (static_cast<int>(seeds.size()) < options_.window_nodes &&
            std::find(seeds.begin(), seeds.end(), end) == seeds.end()) {
          seeds.push_back(end);
        }
        end = hierarchy_.level(l).nodes[end].parent;
      }
    }
  }
}

// Chains that were linearized anew: they pull otherwise than before.
template <typename G>
void Optimizer<G>::Impl::NoteRefreshed() {
  for (const auto& [e, change] : hierarchy_.TakeRefreshed()) {
    if (!hierarchy_.level(0).edges[e].alive) continue;
    AddPending(0, e, change, thresholds_, &hierarchy_);
    TellParent(0, e, change, thresholds_, &hierarchy_);
  }
}

template <typename G>
void Optimizer<G>::Impl::MergeDirtyEdges() {
  constexpr std::size_t kLookAtClock = 64;
  const Stopwatch watch(&report_.merge_seconds);
  const auto goes_on = [&](std::size_t k) {
    return IsUncapped() ? k % kLookAtClock != 0 || !IsStopped()
                        : report_.merged_edges < options_.max_merges;
  };
  for (int l = 1; l < hierarchy_.num_levels(); ++l) {
    Level<G>& level = hierarchy_.mutable_level(l);
    std::size_t k = 0;
    for (; k < level.dirty.size() && goes_on(k); ++k) {
      const Index e = level.dirty[k];
      level.edges[e].dirty = false;
      if (!level.edges[e].alive) continue;
      const double change = hierarchy_.Merge(l, e);
      ++report_.merged_edges;
      AddPending(l, e, change, thresholds_, &hierarchy_);
      TellParent(l, e, change, thresholds_, &hierarchy_);
    }
    level.dirty.erase(level.dirty.begin(), level.dirty.begin() + static_cast<std::ptrdiff_t>(k));
    if (l == 1) NoteRefreshed();
  }
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;

}  // namespace hpgo
