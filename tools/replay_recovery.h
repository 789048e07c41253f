// How fast the updates after a replay take in a far-off loop closure.
#pragma once

#include <string>
#include <vector>

#include "hpgo/optimizer.h"
#include "tools/replay_compare.h"

namespace hpgo_cli {

struct RecoveryPoint {
  int updates = 0;  // since the closure
  double gap_percent = 0;
};

struct Recovery {
  std::string edge;       // "3 -> 97"
  double offset_m = 0;    // how far its measurement is from the estimate
  double edge_chi2 = 0;   // when it is added
  double optimum = 0;     // of the graph with it
  double slowest_ms = 0;  // of the updates, wall time
  bool at_rest = false;   // the updates ended before the last point because nothing was left to do
  std::vector<RecoveryPoint> points;
};

inline constexpr int kMinFarClosureNodes = 20;

// Adds an edge from the newest node to one a twentieth into the map, with the information of the
// first edge, whose measurement is displaced so that its chi2 is `factor` times the mean of the
// edges; then updates up to 100 times. The graph has kMinFarClosureNodes or more. Errors of the
// full solve and the updates.
template <typename G>
hpgo::Result<Recovery> RecoverFromFarClosure(const hpgo::PoseGraph<G>& graph, double factor,
                                             const hpgo::UpdateLimits& limits,
                                             const LossChoice& loss, hpgo::Optimizer<G>* optimizer);

}  // namespace hpgo_cli
