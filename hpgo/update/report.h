// Limits and reports of updates.
#pragma once

#include <atomic>

#include "hpgo/graph/status.h"

namespace hpgo {

// Bounds of one call. The defaults are those of the options.
struct UpdateLimits {
  // Seconds of wall time. If positive, it replaces max_windows, max_merges and max_examined: work
  // goes on until the time is up or nothing is stressed. It is checked between windows, and between
  // the iterations of a full solve; one window is solved at least. Taking in what is new is not cut
  // short; where much comes at once and is far off, a solve of ten times as many edges is a part of
  // it.
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

// The larger of both, each by itself.
Motion Larger(const Motion& a, const Motion& b);

struct UpdateReport {
  // kNoSolution: a solve failed numerically; it changed nothing. The rest was done.
  Status status;
  // Nothing stressed is left, no closure is under way (far_closures.h), or Refine no longer gets
  // anywhere; known to Schedule::kStress only.
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
  double mean_chi2 = 0;      // per edge of level 0, where a chain is one, as last evaluated
  // Seconds of wall time.
  double insert_seconds = 0, merge_seconds = 0, examine_seconds = 0, top_seconds = 0,
         window_seconds = 0, seconds = 0;
};

// Adds the counts and times of one step to those of a call; status, levels and means are the
// latest.
void Accumulate(const UpdateReport& step, UpdateReport* sum);

}  // namespace hpgo
