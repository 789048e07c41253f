// Optimizer: the update.

#include <algorithm>
#include <cmath>
#include <limits>

#include "ceres_costs/factor_term.h"
#include "glog/logging.h"
#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/solver_factory.h"

namespace hpgo {
namespace {

double Seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

// Grows with the angle; about half of it where it is small.
double HalfRotation(const SE2& T) { return 0.5 * std::abs(T.angle()); }
double HalfRotation(const SE3& T) { return T.rotation().vec().norm(); }

double Angle(const SE2& T) { return std::abs(T.angle()); }
double Angle(const SE3& T) { return 2 * std::asin(std::min(1., T.rotation().vec().norm())); }

}  // namespace

// Adds the time it lives to a field of the report.
template <typename G>
class Optimizer<G>::Impl::Stopwatch {
 public:
  explicit Stopwatch(double* total) : total_(total), start_(Clock::now()) {}
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;
  ~Stopwatch() { *total_ += Elapsed(); }
  double Elapsed() const { return Seconds(Clock::now() - start_); }

 private:
  double* total_;
  Clock::time_point start_;
};

template <typename G>
Optimizer<G>::Impl::Impl(const OptimizerOptions& options)
    : options_(options),
      hierarchy_({options.max_group_size, options.max_top_nodes, options.max_top_edges,
                  options.coarse_edges, options.convention}),
      solver_(MakeSolver<G>(options.engine)) {}

template <typename G>
UpdateReport Optimizer<G>::Impl::Update(Mode mode, const UpdateLimits& limits) {
  depth_ = 1;
  return Step(mode, limits);
}

template <typename G>
UpdateReport Optimizer<G>::Impl::Step(Mode mode, const UpdateLimits& limits) {
  report_ = UpdateReport();
  report_.at_rest = true;
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
      SolveFull(limits);
    } else if (mode == Mode::kTop) {
      SolveLevel(hierarchy_.num_levels() - 1, options_.window_iterations);
    } else if (options_.schedule == Schedule::kStress) {
      RunStressSchedule(limits, limits.max_seconds > 0);
    } else {
      RunFixedSchedule();
    }
    new_edges_.clear();
  }
  report_.num_levels = hierarchy_.num_levels();
  report_.newest_moved = MotionBetween(newest_before, NewestPose());
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
  FindNewComponents();
  if (check_anchors_) AlignJoinedComponents();
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
  const Stopwatch watch(&report_.insert_seconds);
  const int num_levels = hierarchy_.num_levels();
  seeds_.resize(num_levels);
  for (std::vector<Index>& seeds : seeds_) seeds.clear();
  had_window_.assign(num_levels, false);
  Level<G>& level = hierarchy_.mutable_level(0);
  for (const EdgeId id : new_edges_) {
    const Result<Index> found = FindEdge(id);
    if (!found.ok()) continue;  // removed since
    const Index e = *found;
    LevelEdge& edge = level.edges[e];
    edge.merged = true;
    const double chi2 = FactorCost(hierarchy_.FactorOf(0, e), edge.node[0] == kNone,
                                   hierarchy_.RelativePose(0, edge.node[0], edge.node[1]));
    if (!std::isfinite(chi2)) {
      report_.status = NotFinite(e);
      continue;
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

template <typename G>
void Optimizer<G>::Impl::MergeDirtyEdges() {
  const Stopwatch watch(&report_.merge_seconds);
  for (int l = 1; l < hierarchy_.num_levels(); ++l) {
    Level<G>& level = hierarchy_.mutable_level(l);
    std::size_t k = 0;
    for (; k < level.dirty.size() && report_.merged_edges < options_.max_merges; ++k) {
      const Index e = level.dirty[k];
      level.edges[e].dirty = false;
      if (!level.edges[e].alive) continue;
      const double change = hierarchy_.Merge(l, e);
      ++report_.merged_edges;
      AddPending(l, e, change, thresholds_, &hierarchy_);
      TellParent(l, e, change, thresholds_, &hierarchy_);
    }
    level.dirty.erase(level.dirty.begin(), level.dirty.begin() + static_cast<std::ptrdiff_t>(k));
  }
}

template <typename G>
bool Optimizer<G>::Impl::TopIsSmall() const {
  // Larger only where many components keep the top from shrinking.
  const Level<G>& top = hierarchy_.level(hierarchy_.num_levels() - 1);
  return top.num_nodes / 2 <= options_.max_top_nodes && top.num_edges / 2 <= options_.max_top_edges;
}

template <typename G>
void Optimizer<G>::Impl::SolveLevel(int l, int iterations) {
  if (!window_.BuildWhole(l, &hierarchy_)) return;
  SolveWindow(iterations);
}

// Solves the window and takes the result if the cost has fallen.
template <typename G>
bool Optimizer<G>::Impl::SolveWindow(int max_iterations) {
  constexpr double kLargestScale = 10, kScaleGrowth = 1.5;
  SubproblemOptions options;
  options.max_iterations = max_iterations;
  if (limits_ != nullptr) options.cancel = limits_->cancel;
  const SubproblemSummary summary = solver_->Solve(options, &window_.subproblem());
  report_.solved_nodes += window_.subproblem().num_free;
  largest_scale_ = summary.damped ? 1 : std::min(kLargestScale, kScaleGrowth * largest_scale_);
  const bool usable = summary.status.ok() || summary.status.code() == StatusCode::kInterrupted;
  if (!usable) report_.status = WhyUnusable(summary.status);
  if (!usable || !(summary.final_cost < summary.initial_cost)) return false;
  if (!LevelBelowGains()) return false;
  window_.Commit(&hierarchy_);
  NoteMotions();
  report_.cost_decrease += summary.initial_cost - summary.final_cost;
  RecordChanges(summary);
  return true;
}

// Whether the edges that the window's were made from agree that the cost falls. A coarse edge says
// little about far motions, least of all after those of levels above.
template <typename G>
bool Optimizer<G>::Impl::LevelBelowGains() const {
  constexpr double kFar = 0.025;  // half radians; nearer, both agree
  if (window_.level() == 0 || options_.coarse_edges != CoarseEdges::kGalerkin) return true;
  bool far = false;
  double gain = 0;
  for (std::size_t k = 0; k < window_.edges().size(); ++k) {
    far |= !(HalfRotation(window_.RelativePoseBefore(k).Between(window_.RelativePose(k))) < kFar);
  }
  if (!far) return true;
  for (std::size_t k = 0; k < window_.edges().size(); ++k) {
    const Index e = window_.edges()[k];
    gain += hierarchy_.ChildrenCost(window_.level(), e, window_.RelativePoseBefore(k)) -
            hierarchy_.ChildrenCost(window_.level(), e, window_.RelativePose(k));
  }
  return gain > 0;
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
Status Optimizer<G>::Impl::NotFinite(Index edge) const {
  return Status(StatusCode::kNoSolution,
                NameOf(edge) + ": its cost cannot be evaluated at the estimate");
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
void Optimizer<G>::Impl::RecordChanges(const SubproblemSummary& summary) {
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
      hierarchy_.SetPending(l, e, static_cast<float>(unexplained), thresholds_.pending);
    } else {
      AddPending(l, e, change, thresholds_, &hierarchy_);
    }
  }
}

// Finds work on a level and does it; false if there is none.
template <typename G>
bool Optimizer<G>::Impl::ServeStressed(int l) {
  constexpr double kNewShare = 0.2;
  FoundWork work;
  {
    const Stopwatch watch(&report_.examine_seconds);
    work = FindWork(l, options_.max_examined, options_.window_edges, thresholds_, &hierarchy_);
  }
  report_.examined_edges += work.examined;
  if (!work.found) return false;
  if (l == hierarchy_.num_levels() - 1 && TopIsSmall()) {
    const Stopwatch watch(&report_.top_seconds);
    ++report_.top_solves;
    SolveLevel(l, options_.window_iterations);
    return true;
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
  if (window_.Build(l, seeds, NextWindow(), &hierarchy_)) {
    SolveWindow(options_.window_iterations);
    const double seconds_per_edge = watch.Elapsed() / static_cast<double>(window_.edges().size());
    const double share = seconds_per_edge_ > 0 ? kNewShare : 1;
    seconds_per_edge_ += share * (seconds_per_edge - seconds_per_edge_);
  }
  return true;
}

// Of the same work, fewer and larger windows carry a correction further: where time is what bounds
// the work they are as large as a part of it allows, and large where nothing does. One that needed
// damping is followed by small ones.
template <typename G>
WindowLimits Optimizer<G>::Impl::NextWindow() const {
  constexpr double kShareOfTime = 0.34;
  double scale = 1;
  if (limits_->max_seconds > 0) {
    const double left = limits_->max_seconds - Seconds(Clock::now() - started_);
    const double seconds = std::min(kShareOfTime * limits_->max_seconds, left);
    const double usual = seconds_per_edge_ * options_.window_edges;
    if (usual > 0) scale = std::clamp(seconds / usual, 1., largest_scale_);
  } else if (refining_) {
    scale = largest_scale_;
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
    return hierarchy_.level(l).dirty.empty() && ServeStressed(l);
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
