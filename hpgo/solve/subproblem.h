// What a solver gets: poses, some of them free, and the factors between them. A window of a level
// and a whole graph are both this.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "ceres_costs/factor_term.h"
#include "hpgo/graph/status.h"

namespace hpgo {

// The index that stands for the world frame, at the identity and never free.
inline constexpr int kWorldFrame = -1;

// A factor between two poses, or on one pose where i is kWorldFrame (a prior; see FactorTerm for
// the fields it inherits). Owns nothing.
template <typename G>
struct Factor : ceres_costs::FactorTerm<G> {
  int i = kWorldFrame;  // index into Subproblem::poses
  int j = 0;
};

// The objective is the sum over factors, without the factor 1/2.
template <typename G>
struct Subproblem {
  std::vector<G> poses;  // T_world_node; the first num_free are free, the others constant
  int num_free = 0;
  std::vector<Factor<G>> factors;
};

// T_i_j of a factor's poses; T_world_j where i is the world.
template <typename G>
G RelativePose(const Factor<G>& factor, const std::vector<G>& poses) {
  const G& X_j = poses[factor.j];
  return factor.i == kWorldFrame ? X_j : poses[factor.i].Between(X_j);
}

// The objective at other poses of the same problem.
template <typename G>
double CostAt(const Subproblem<G>& problem, const std::vector<G>& poses) {
  double cost = 0;
  for (const Factor<G>& factor : problem.factors) {
    cost += FactorCost(factor, factor.i == kWorldFrame, RelativePose(factor, poses));
  }
  return cost;
}

// Of chi2, a factor: what rounding leaves where there is no noise.
inline constexpr double kRoundingOfAFactor = 1e-18;

struct SubproblemOptions {
  int max_iterations = 1;
  // Seconds of wall time; checked after each iteration, so that one is made in any.
  double max_seconds = 1e9;
  // Ends when an iteration's relative decrease of the cost falls below it.
  double function_tolerance = 1e-10;
  // The trust region to begin with; 1e8 is as good as undamped Gauss-Newton.
  double initial_trust_region_radius = 1e8;
  // Set from elsewhere (another thread, a signal handler) to stop after the current iteration.
  const std::atomic<bool>* cancel = nullptr;
  // Called after each iteration with its number and the cost so far; may be empty.
  std::function<void(int iteration, double cost)> progress;
};

struct SubproblemSummary {
  // kNoSolution: numerical failure, the poses are unchanged. kInterrupted: cancelled; the poses
  // hold the best so far.
  Status status;
  double initial_cost = 0;
  double final_cost = 0;
  double predicted_decrease = 0;  // of the linearized objective, summed over accepted iterations
  int iterations = 0;             // attempted steps
  bool converged = false;         // false: a limit ended it
  bool damped = false;            // a full Gauss-Newton step was not enough
  double seconds = 0;
};

// Minimizes a Subproblem in place. An object keeps its workspace between calls: use one per thread.
template <typename G>
class SubproblemSolver {
 public:
  virtual ~SubproblemSolver() = default;
  virtual SubproblemSummary Solve(const SubproblemOptions& options, Subproblem<G>* problem) = 0;
};

}  // namespace hpgo
