// Exact optimization of a whole pose graph.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/pose_graph.h"
#include "hpgo/solve/engine.h"
#include "hpgo/solve/initial_guess.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

enum class LossScope {
  kLoopClosures,  // of edge_classes.h
  kAllEdges,
};

struct FullSolveOptions {
  InitMethod init = InitMethod::kAuto;
  Engine engine = Engine::kBlock;
  ceres_costs::ErrorConvention convention = ceres_costs::ErrorConvention::kG2o;
  // A robust loss by name (ceres_costs/losses.h) and its scale, in units of the whitened error.
  // Priors are never robust.
  std::string loss = "none";
  double loss_scale = 1;
  LossScope loss_on = LossScope::kLoopClosures;
  // Of each run to the end (below). Work ends it too: 3e8 evaluations of an edge or prior, though
  // never before 200 iterations.
  int max_iterations = 1000000;
  // Seconds of wall time for everything; checked between iterations.
  double max_seconds = 1e9;
  // The solve ends when an iteration decreases the cost by less than this share. To be loosened
  // when an approximate optimum is enough.
  double function_tolerance = 1e-10;
  // Of Levenberg-Marquardt; so large it begins undamped, and shrinks where that does not help.
  // Ceres' default, 1e4, takes several times the iterations where the start is good.
  double initial_trust_region_radius = 1e12;
  // Set from elsewhere (another thread, a signal handler) to stop after the current iteration.
  const std::atomic<bool>* cancel = nullptr;
  // Called after each iteration with its number and the cost so far; may be empty.
  std::function<void(int iteration, double cost)> progress;
};

struct FullSolveReport {
  // kInvalidArgument: an option or a value of the graph cannot be used; the message names it.
  // kNoSolution: no start or a numerical failure. In both cases the graph is unchanged.
  // kInterrupted: cancelled; the graph holds the best so far, unchanged if that is the input.
  Status status;
  bool converged = false;  // false with an ok status: a limit ended it, the result is usable
  // The sum of e' Omega e over edges and priors in the convention, without the factor 1/2 and
  // without the loss: at the graph's own poses (those missing composed from their neighbours'), at
  // the initial guess, and at the result.
  double chi2_before = 0;
  double chi2_start = 0;
  double chi2_after = 0;
  // The same with the loss: what is minimized. Equal to chi2 without one.
  double cost_before = 0;
  double cost_start = 0;
  double cost_after = 0;
  InitMethod init = InitMethod::kFile;    // the one used
  std::vector<InitCandidate> candidates;  // with their costs, and those found on the way
  int runs = 0;                           // the candidates solved to the end
  int components = 0;
  int loop_closures = 0;
  int held_nodes = 0;            // fixed ones, and one of each component that nothing anchors
  std::vector<NodeId> anchored;  // those of them that are not fixed
  int iterations = 0;            // of all runs
  // Those that could move without a change of the linearized objective, in the graph's order; see
  // undetermined.h.
  std::vector<NodeId> undetermined;
  double init_seconds = 0;
  double solve_seconds = 0;
  double seconds = 0;  // all of it
};

// Minimizes the graph's objective in place, from the start of the lowest cost. InitMethod::kAuto
// then runs other starts to the end too, and guesses made anew with less weight on the edges that
// are far off, until three have ended at the lowest cost or they have cost enough: little in all (a
// second) or, where chi2 per degree of freedom is far above 1, a few times as much as the first.
// The lowest end is the result. A redescending loss is approached from a convex one
// (graduated_loss.h), and starts are then compared with that.
//
// Moves every node that is neither fixed nor the first,
// in id order, of a component that nothing anchors. Afterwards every node has a pose; fixed nodes
// are as they were, bit for bit. Deterministic unless a time limit or `cancel` ends it.
template <typename G>
FullSolveReport SolveFull(const FullSolveOptions& options, PoseGraph<G>* graph);

}  // namespace hpgo
