// How far the estimate is from the full optimum right after the updates that take in a loop
// closure.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hpgo/replay.h"
#include "tools/replay_compare.h"
#include "tools/replay_statistics.h"

namespace hpgo_cli {

struct ClosureFigures {
  std::int64_t closing_updates = 0;         // of the replay
  std::vector<FullComparison> comparisons;  // right after some of them, in order
  Distribution gap_percent() const;
  Distribution ate_m() const;
};

// At most `count` of the numbers 0 to `total` - 1, evenly spread, with the first and the last (of
// one the last).
std::vector<std::int64_t> SampleEvenly(std::int64_t total, std::int64_t count);

// The full optimum of a growing graph, followed from closure to closure. Each time there are two
// starts: the optimizer's estimate, which is near, and the optimum found last with the nodes since
// composed from their edges. The second owes nothing to the optimizer's updates, unless a solve
// from the estimate came out lower before: where the estimate sits in a local optimum, or moved
// little because it is stuck, it is this one that shows it. What is left is an optimum that both
// miss; the chordal start of CompareWithFull looks for those at the end of a replay, and costs as
// much again.
template <typename G>
class ClosureReference {
 public:
  // Of `graph`'s steps; it must outlive this.
  ClosureReference(const hpgo::PoseGraph<G>& graph, const LossChoice& loss);

  // The node of the next step.
  hpgo::Status Add(const hpgo::ReplayStep& step);

  // The optimizer holds the nodes added so far. Errors are those of CompareWithFull.
  hpgo::Result<FullComparison> Compare(const hpgo::Optimizer<G>& optimizer);

 private:
  const hpgo::PoseGraph<G>& graph_;
  const LossChoice loss_;
  std::vector<G> poses_;  // by index in graph_
  std::vector<int> added_;
};

// The gaps and distances over the number of nodes, as SVG.
hpgo::Result<std::string> ClosureChart(const ClosureFigures& figures, const std::string& title);

}  // namespace hpgo_cli
