#include "tools/replay_comparisons.h"

#include "tools/signals.h"

namespace hpgo_cli {

using hpgo::SE2;
using hpgo::SE3;
using hpgo::YawPose;

template <typename G>
ReplayComparisons<G>::ReplayComparisons(const hpgo::PoseGraph<G>& graph,
                                        const ReplaySettings& settings,
                                        const hpgo::Optimizer<G>& optimizer, ReplayResult* result)
    : num_nodes_(graph.nodes().size()),
      settings_(settings),
      optimizer_(optimizer),
      result_(*result),
      reference_(graph, settings.loss) {}

template <typename G>
void ReplayComparisons<G>::SkipTo(std::size_t nodes) {
  while (IsDue(nodes)) ++next_;
}

template <typename G>
hpgo::Status ReplayComparisons<G>::Add(const hpgo::ReplayStep& step) {
  return closures_.empty() ? hpgo::Status::Ok() : reference_.Add(step);
}

template <typename G>
void ReplayComparisons<G>::AfterUpdate(std::size_t nodes, bool closes_loop) {
  CompareIfClosing(closes_loop);
  CompareIfDue(nodes);
}

template <typename G>
void ReplayComparisons<G>::CompareIfClosing(bool closes_loop) {
  if (!closes_loop) return;
  const std::int64_t number = result_.closures.closing_updates++;
  std::vector<FullComparison>& done = result_.closures.comparisons;
  if (next_closure_ == closures_.size() || CancelFlag()) return;
  if (closures_[next_closure_] != number) return;
  ++next_closure_;
  const std::optional<FullComparison> comparison = Accept(reference_.Compare(optimizer_));
  if (!comparison.has_value()) return;
  done.push_back(*comparison);
  done.back().percent = 100.0 * static_cast<double>(comparison->nodes) / num_nodes_;
}

template <typename G>
bool ReplayComparisons<G>::IsDue(std::size_t nodes) const {
  if (next_ == settings_.compare_at.size()) return false;
  const double share = settings_.compare_at[next_] / 100;
  return static_cast<double>(nodes) >= share * static_cast<double>(num_nodes_);
}

// At the first update with so many percent of the nodes.
template <typename G>
void ReplayComparisons<G>::CompareIfDue(std::size_t nodes) {
  while (IsDue(nodes) && !CancelFlag()) {
    const double percent = settings_.compare_at[next_++];
    const std::optional<FullComparison> comparison = Compare(percent);
    if (comparison.has_value()) result_.comparisons.push_back(*comparison);
  }
}

template <typename G>
std::optional<FullComparison> ReplayComparisons<G>::Compare(double percent) {
  std::optional<FullComparison> comparison = Accept(CompareWithFull(optimizer_, settings_.loss));
  if (comparison.has_value()) comparison->percent = percent;
  return comparison;
}

// Notes a failure.
template <typename G>
std::optional<FullComparison> ReplayComparisons<G>::Accept(
    const hpgo::Result<FullComparison>& comparison) {
  if (comparison.ok()) return *comparison;
  const bool interrupted = comparison.status().code() == hpgo::StatusCode::kInterrupted;
  if (!interrupted && result_.comparison_failure.ok()) {
    result_.comparison_failure = comparison.status();
  }
  return std::nullopt;
}

template class ReplayComparisons<SE2>;
template class ReplayComparisons<SE3>;
template class ReplayComparisons<YawPose>;

}  // namespace hpgo_cli
