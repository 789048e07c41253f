// How far an incremental estimate is from the full optimum of the same graph, and from the truth.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hpgo/evaluate/trajectory_error.h"
#include "hpgo/optimizer.h"
#include "tools/pose_source.h"

namespace hpgo_cli {

struct FullComparison {
  double percent = 0;  // of the replay
  std::int64_t nodes = 0, edges = 0;
  double cost = 0;     // of the estimate: chi2, with the loss if there is one
  double optimum = 0;  // the lower cost of two full solves
  std::string start;   // of that one: "estimate", "chordal" or "reference"
  double gap_percent = 0;
  double ate_m = 0, ate_rad = 0;  // rmse against the optimum, after rigid alignment
  double seconds = 0;             // of the two solves
};

// A loss by name, as in FullSolveOptions.
struct LossChoice {
  std::string name = "none";
  double scale = 1;
};

// Null for "none". The choice must be valid.
std::shared_ptr<const ceres::LossFunction> MakeSharedLoss(const LossChoice& choice);

// 100 (cost / optimum - 1); an optimum below 1e-6 an edge counts as that much, so that a graph
// without noise has a gap too. Not a number where the cost is not one.
double GapPercent(double cost, double optimum, std::int64_t edges);

// Gives two estimates of one graph the lower optimum: a solve from the better one may find a better
// one.
void ShareOptimum(FullComparison* a, FullComparison* b);

// Solves the graph to its optimum from the estimate and from a chordal start; the estimate itself
// is the optimum where its cost is not above theirs. kNoSolution if both fail, kInterrupted if the
// user interrupts.
template <typename G>
hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<G>& optimizer,
                                             const LossChoice& loss);

// The same with `reference` as the second start, a graph with a pose for each node of the
// optimizer; it becomes the optimum found.
template <typename G>
hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<G>& optimizer,
                                             const LossChoice& loss, hpgo::PoseGraph<G>* reference);

struct ReferenceError {
  std::int64_t poses = 0;         // matched
  double ate_m = 0, ate_rad = 0;  // rmse after rigid alignment
};

// In 2D where the estimate is planar or --plane is given.
template <typename G>
hpgo::Result<ReferenceError> CompareWithReference(const hpgo::PoseGraph<G>& estimate,
                                                  const std::string& name,
                                                  const PoseSource& reference);

}  // namespace hpgo_cli
