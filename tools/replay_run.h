// One replay of a recorded graph: every update, what it took, and the comparisons on the way.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hpgo/optimizer.h"
#include "tools/replay_closures.h"
#include "tools/replay_compare.h"
#include "tools/replay_statistics.h"

namespace hpgo_cli {

struct ReplaySettings {
  hpgo::OptimizerOptions options;
  double update_seconds = 0;  // UpdateLimits::max_seconds
  // Nodes between two updates; 0: an update at each node with a loop closure. The last node is
  // always updated.
  int solve_every = 1;
  LossChoice loss;  // of the loop closures
  // The statistics are of the updates at more than this share of the nodes.
  double stats_from = 0;
  // If set, the last `measure_updates` nodes are updated in this mode, and the statistics are of
  // them alone.
  std::optional<hpgo::Mode> measure_mode;
  int measure_updates = 10;
  std::string stats_csv;           // a file with a line an update; empty: none
  int chi2_every = 0;              // updates between two values of chi2 there; 0: none
  std::vector<double> compare_at;  // percent of the nodes, ascending
  int compare_closures = 0;        // closing updates after which to compare, at most; 0: none
  // The client takes the poses of all nodes once in so many updates, and new nodes start in those
  // it has; 0: in the current estimate.
  int stale_poses = 0;
  bool refine = false;  // to rest, after the last update
  // The optimizer's state goes to this file at the end, and after so many nodes (0: only then).
  std::string save;
  int save_every = 0;
  double far_closure = 0;  // see RecoverFromFarClosure; 0: none
};

struct RefineResult {
  hpgo::UpdateReport report;
  double cost_before = 0, cost_after = 0;
  std::optional<FullComparison> before, after;
};

struct ReplayResult {
  bool interrupted = false;  // the replay ended early
  std::int64_t steps = 0;    // nodes added, those of a resumed state among them
  std::int64_t updates = 0;
  double seconds = 0;  // of wall time in the updates
  std::int64_t windows = 0, top_solves = 0, merged_edges = 0, examined_edges = 0, solved_nodes = 0;
  std::int64_t failed_updates = 0;
  hpgo::Status first_failure;
  std::vector<UpdateSample> samples;  // those that count
  std::vector<FullComparison> comparisons;
  ClosureFigures closures;
  hpgo::Status comparison_failure;  // the first one
  std::optional<RefineResult> refine;
  // The largest size of the process so far, bytes; the input graph and comparisons are part of it.
  std::int64_t peak_memory = 0;
  std::size_t optimizer_memory = 0;  // bytes
};

// The sum of e' Omega e over edges and priors, without the loss.
template <typename G>
double Chi2(const hpgo::Optimizer<G>& optimizer);

// Replays `graph` into an optimizer with the same options, that is empty or where the first nodes
// have been replayed before. Errors: those of the steps, and of writing stats_csv and states;
// kInvalidArgument where the optimizer holds something else. Shows a progress line.
template <typename G>
hpgo::Result<ReplayResult> RunReplay(const hpgo::PoseGraph<G>& graph,
                                     const ReplaySettings& settings, hpgo::Optimizer<G>* optimizer);

}  // namespace hpgo_cli
