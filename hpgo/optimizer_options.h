// Options, limits and reports of the Optimizer.
#pragma once

#include <atomic>
#include <string>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/status.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/solve/subproblem.h"

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
  int max_group_size = 3;   // K
  int max_top_nodes = 300;  // T: a larger top gets a new level. Larger: better, slower closures
  // Kept nodes that are all solved at once, exactly, while there are no more. Larger: closures are
  // exact in larger maps, and take longer there.
  int max_whole_nodes = 800;
  int max_top_edges = 1500;  // so does one with more edges
  CoarseEdges coarse_edges = CoarseEdges::kGalerkin;
  // Chains of nodes with two edges each are condensed exactly, and level 0 of the hierarchy is the
  // nodes between them; false: it is all nodes, as in the paper.
  bool condense_chains = true;
  Schedule schedule = Schedule::kStress;
  int window_nodes = 200;   // P: free nodes of a window
  int window_edges = 1000;  // edges of a window
  // M: windows an update, twice as many while a far-off closure needs damped steps. More: faster
  // convergence, longer updates.
  int max_windows = 6;
  // Of a window's solve, and of the top's; a few more for damped ones as long as that lasts.
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
  // As published: condensed edges, a window at the newest node, the top solved at every update.
  static OptimizerOptions Paper();
  // "accurate", "fast", "eager", "paper"; kInvalidArgument for any other name.
  static Result<OptimizerOptions> FromName(const std::string& name);

  // kInvalidArgument, naming the field that is out of range.
  Status Validate() const;
};

// Bounds of one call. The defaults are those of the options.
struct UpdateLimits {
  // Seconds of wall time. If positive, it replaces max_windows, max_merges and max_examined: work
  // goes on until the time is up or nothing is stressed. It is checked between windows, and between
  // the iterations of a full solve; one window is solved at least.
  double max_seconds = 0;
  // The same in CPU time of the calling thread: on busy cores the same work is done.
  double max_cpu_seconds = 0;
  // Set from elsewhere to stop between two windows.
  const std::atomic<bool>* cancel = nullptr;
};

struct Motion {
  double distance = 0;  // m
  double angle = 0;     // rad
};

struct UpdateReport {
  // kNoSolution: a solve failed numerically; it changed nothing. The rest was done.
  Status status;
  // Nothing stressed is left, or Refine no longer gets anywhere; known to Schedule::kStress only.
  bool at_rest = false;
  int new_nodes = 0;  // inserted by this update
  int new_edges = 0;
  int merged_edges = 0;  // coarse edges computed anew
  int examined_edges = 0;
  int windows = 0;  // solved, the top's solve not among them
  int top_solves = 0;
  int solved_nodes = 0;  // free poses, summed over all solves
  int num_levels = 0;
  // How far the solves have moved the newest node, and the largest motions of nodes and groups that
  // were solved for: a robot that follows the map jumps by these.
  Motion newest_moved, largest_moved;
  double cost_decrease = 0;  // of the objectives of the windows, summed
  double mean_chi2 = 0;      // per edge, as last evaluated
  // Seconds of wall time.
  double insert_seconds = 0, merge_seconds = 0, examine_seconds = 0, top_seconds = 0,
         window_seconds = 0, seconds = 0;
};

}  // namespace hpgo
