// When a replay compares its estimate with the full optimum, and what that shows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "hpgo/replay.h"
#include "tools/replay_closures.h"
#include "tools/replay_run.h"

namespace hpgo_cli {

// Compares right after some of the updates that take in a loop closure, and at shares of the nodes.
// After an interruption it compares no more.
template <typename G>
class ReplayComparisons {
 public:
  // Of a replay of `graph` into `optimizer`; all must outlive this. The comparisons go to `result`,
  // and the first that fails.
  ReplayComparisons(const hpgo::PoseGraph<G>& graph, const ReplaySettings& settings,
                    const hpgo::Optimizer<G>& optimizer, ReplayResult* result);

  // The numbers, among the updates that take in a closure, of those to compare after.
  void SetClosures(std::vector<std::int64_t> numbers) { closures_ = std::move(numbers); }
  // Leaves out what was due before the replay goes on behind so many nodes.
  void SkipTo(std::size_t nodes);

  // A node has been added.
  hpgo::Status Add(const hpgo::ReplayStep& step);
  // An update has ended, with so many nodes.
  void AfterUpdate(std::size_t nodes, bool closes_loop);

  // Now; nothing if that fails.
  std::optional<FullComparison> Compare(double percent);

 private:
  void CompareIfClosing(bool closes_loop);
  bool IsDue(std::size_t nodes) const;
  void CompareIfDue(std::size_t nodes);
  std::optional<FullComparison> Accept(const hpgo::Result<FullComparison>& comparison);

  const std::size_t num_nodes_;
  const ReplaySettings& settings_;
  const hpgo::Optimizer<G>& optimizer_;
  ReplayResult& result_;
  std::size_t next_ = 0;  // of settings_.compare_at
  ClosureReference<G> reference_;
  std::vector<std::int64_t> closures_;
  std::size_t next_closure_ = 0;  // of those
};

}  // namespace hpgo_cli
