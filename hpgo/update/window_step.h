// One solve of a window, and what follows from it.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "hpgo/chains/condensed_graph.h"
#include "hpgo/schedule/stress.h"
#include "hpgo/solve/engine.h"
#include "hpgo/solve/window.h"
#include "hpgo/update/budget.h"
#include "hpgo/update/seen_cost.h"

namespace hpgo {

// Names an edge of level 0 in a message.
using LevelEdgeNamer = std::function<std::string(Index level_edge)>;

// What it did.
struct StepResult {
  Status status;              // kNoSolution: it changed nothing
  bool is_nonlinear = false;  // it missed what its linearization promised: another is worth it
  double missed = 0;          // so much of it
  bool converged = false;
  bool damped = false;
  int solved_nodes = 0;
  double initial_cost = 0;       // of the window
  double decrease = 0;           // of it
  bool is_seen_to_rise = false;  // the cost as its caller sees it, which must not: not taken
  Motion largest_moved;
};

// Adds it to a report.
void Note(const StepResult& step, UpdateReport* report);

// Solves windows. Keeps no more than workspace from one to the next. Not synchronized.
template <typename G>
class WindowStep {
 public:
  WindowStep(Engine engine, Hierarchy<G>* hierarchy, LevelEdgeNamer name);

  // To be built on a level before Solve.
  Window<G>& window() { return window_; }
  // Solves the window, takes the result if the cost falls, and passes on what has changed by it:
  // to the edges around, to those below, and to those above. A step that raises the cost its caller
  // sees is not taken where that must not rise.
  StepResult Solve(int max_iterations, double max_seconds, const StressThresholds& thresholds,
                   const Budget& budget, const SeenCost<G>& seen = {});
  // The same by another solver. With `is_known` its step is no minimum: what was pending stays so,
  // and edges of which the solver does not know pull otherwise where they have changed.
  using IsKnown = std::function<bool(Index level_edge)>;
  StepResult SolveBy(SubproblemSolver<G>* solver, SubproblemOptions options,
                     const StressThresholds& thresholds, const Budget& budget,
                     const IsKnown& is_known = {}, const SeenCost<G>& seen = {});
  // Takes the poses that the window's subproblem has been given, found by another solve, and passes
  // on what has changed; `left_behind` as in RecordChanges.
  void Take(double left_behind, const StressThresholds& thresholds);
  // Why nothing can be solved that holds this edge.
  Status NotFinite(Index level_edge) const;

 private:
  bool IsTaken(double gained, const SeenCost<G>& seen, StepResult* result) const;
  bool ChainsGain(double cost_before, const SeenCost<G>& seen, SubproblemSummary* summary,
                  StepResult* result);
  std::vector<double> Changes() const;
  double GraphGain(double promised, const std::vector<double>& changes,
                   const SeenCost<G>& seen) const;
  void Take(const std::vector<double>& changes, double left_behind,
            const StressThresholds& thresholds, const IsKnown& is_known);
  Motion LargestMoved() const;
  Status WhyUnusable(const Status& status) const;
  void RecordChanges(const std::vector<double>& changes, double left_behind,
                     const StressThresholds& thresholds, const IsKnown& is_known);

  Hierarchy<G>* hierarchy_;
  LevelEdgeNamer name_;
  std::unique_ptr<SubproblemSolver<G>> solver_;
  Window<G> window_;
};

extern template class WindowStep<ceres_costs::SE2>;
extern template class WindowStep<ceres_costs::SE3>;
extern template class WindowStep<ceres_costs::YawPose>;

}  // namespace hpgo
