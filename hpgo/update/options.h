// Options of the Optimizer.
#pragma once

#include <string>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/status.h"
#include "hpgo/hierarchy/coarse_edges.h"
#include "hpgo/solve/engine.h"

namespace hpgo {

// What an update solves (paper, Figure 4).
enum class Mode {
  kPartial,  // the top level and a window on every lower level that needs one
  kTop,      // the top level only
  kFull,     // the whole graph, to convergence
};

// Which windows a partial update opens.
enum class Schedule {
  kStress,  // where the predicted decrease of chi2 is worth it; at any distance from the new edges
  kNewEdges,    // on every level, around both ends of every new edge
  kNewestNode,  // on every level, around the newest node: the paper's
};

struct OptimizerOptions {
  // --- These change the result.
  int max_group_size = 3;  // K
  // T: the top is solved as a whole, and gets a new level when it is larger: while there are no
  // more kept nodes than this, closures are exact. Larger: exact in larger maps, nearer the optimum
  // in those beyond, slower closures.
  int max_top_nodes = 400;
  int max_top_edges = 1000;  // so does one with more edges
  CoarseEdges coarse_edges = CoarseEdges::kGalerkin;
  // Chains of nodes with two edges each are condensed exactly, and level 0 of the hierarchy is the
  // nodes between them; false: it is all nodes, as in the paper.
  bool condense_chains = true;
  Schedule schedule = Schedule::kStress;
  int window_nodes = 200;   // P: free nodes of a window
  int window_edges = 1000;  // edges of a window
  // M: windows an update, the top's solve among them, each worth as many as it is larger than the
  // options say. More: faster convergence, longer updates.
  int max_windows = 4;
  // Of a window's solve, and of the top's; fixed schedules solve the top to convergence.
  int window_iterations = 1;
  // Stress threshold, relative to the mean chi2 of an edge. Smaller: closer to the optimum, slower.
  double stress_threshold = 5e-4;
  int max_examined = 300;  // C: edges looked at in one search for work
  int max_merges = 2000;   // coarse edges merged an update; the others wait for the next
  ceres_costs::ErrorConvention convention = ceres_costs::ErrorConvention::kG2o;
  Mode mode = Mode::kPartial;
  // --- These change the speed only, up to rounding.
  Engine engine = Engine::kBlock;

  static OptimizerOptions Accurate() { return {}; }
  static OptimizerOptions Fast();
  // Windows around every new edge at every update, whether stressed or not.
  static OptimizerOptions Eager();
  // As published: condensed edges, a window at the newest node, the top solved at every update. The
  // paper leaves P open; here it is 2000. The gap right after a closure, mean of 40, was with P =
  // 800 19 % on KITTI 00 and 0.02 % on M3500, with 2000 1.2 % and 0.0002 %, for 1.5 times the CPU
  // time.
  static OptimizerOptions Paper();
  // "accurate", "fast", "eager", "paper"; kInvalidArgument for any other name.
  static Result<OptimizerOptions> FromName(const std::string& name);

  // kInvalidArgument, naming the field that is out of range.
  Status Validate() const;

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.max_group_size, self.max_top_nodes, self.max_top_edges, self.coarse_edges,
            self.condense_chains, self.schedule, self.window_nodes, self.window_edges,
            self.max_windows, self.window_iterations, self.stress_threshold, self.max_examined,
            self.max_merges, self.convention, self.mode, self.engine);
  }
};

}  // namespace hpgo
