#include "tools/replay_compare.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ceres_costs/losses.h"
#include "glog/logging.h"
#include "hpgo/evaluate/compare_poses.h"
#include "hpgo/solve/full_solve.h"
#include "tools/common_flags.h"
#include "tools/signals.h"

namespace hpgo_cli {
namespace {

using hpgo::SE2;
using hpgo::SE3;
using hpgo::StatusCode;
using hpgo::YawPose;

template <typename G>
hpgo::Result<ReferenceError> ErrorOfMatched(const std::vector<G>& estimate,
                                            const std::vector<G>& reference,
                                            const PoseMatches& matches) {
  std::vector<G> estimated, truth;
  for (const auto& [first, second] : matches.pairs) {
    estimated.push_back(estimate[first]);
    truth.push_back(reference[second]);
  }
  const auto error = hpgo::AbsoluteTrajectoryError(estimated, truth);
  if (!error.ok()) return error.status();
  ReferenceError result;
  result.poses = static_cast<std::int64_t>(estimated.size());
  result.ate_m = error->translation.rmse;
  result.ate_rad = error->rotation.rmse;
  return result;
}

template <typename G>
struct FullStart {
  const char* name;
  hpgo::InitMethod init;
  const hpgo::PoseGraph<G>* graph;
};

// Solves from each start in turn; the lowest result goes to `best`, which may be null.
template <typename G>
hpgo::Result<FullComparison> Compare(const hpgo::Optimizer<G>& optimizer, const LossChoice& loss,
                                     const hpgo::PoseGraph<G>& estimate,
                                     const std::vector<FullStart<G>>& starts,
                                     hpgo::PoseGraph<G>* best) {
  hpgo::FullSolveOptions options;
  options.engine = hpgo::Engine::kBlock;
  options.convention = optimizer.options().convention;
  options.loss = loss.name;
  options.loss_scale = loss.scale;
  options.cancel = &CancelFlag();

  FullComparison comparison;
  comparison.nodes = static_cast<std::int64_t>(optimizer.num_nodes());
  comparison.edges = static_cast<std::int64_t>(optimizer.num_edges());
  comparison.cost = optimizer.Cost();
  hpgo::PoseGraph<G> lowest;
  hpgo::Status failure;
  for (const FullStart<G>& start : starts) {
    hpgo::PoseGraph<G> graph = *start.graph;
    options.init = start.init;
    const hpgo::FullSolveReport report = hpgo::SolveFull(options, &graph);
    comparison.seconds += report.seconds;
    if (report.status.code() == StatusCode::kInterrupted) return report.status;
    if (!report.status.ok()) {
      failure = report.status;
    } else if (comparison.start.empty() || report.cost_after < comparison.optimum) {
      comparison.optimum = report.cost_after;
      comparison.start = start.name;
      lowest = std::move(graph);
    }
  }
  if (comparison.start.empty()) return failure;
  if (comparison.cost < comparison.optimum) {
    comparison.optimum = comparison.cost;
    comparison.start = "estimate";
    lowest = estimate;
  }
  comparison.gap_percent = GapPercent(comparison.cost, comparison.optimum, comparison.edges);
  const auto error = hpgo::ComparePosesUpToGauge(estimate, lowest);
  if (!error.ok()) return error.status();
  comparison.ate_m = error->translation.rmse;
  comparison.ate_rad = error->rotation.rmse;
  if (best != nullptr) *best = std::move(lowest);
  return comparison;
}

}  // namespace

std::shared_ptr<const ceres::LossFunction> MakeSharedLoss(const LossChoice& choice) {
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  CHECK(ceres_costs::MakeLoss(choice.name, choice.scale, &loss, &error)) << error;
  return loss;
}

double GapPercent(double cost, double optimum, std::int64_t edges) {
  const double floor = 1e-6 * static_cast<double>(std::max<std::int64_t>(1, edges));
  return 100 * (cost - optimum) / std::max(optimum, floor);
}

void ShareOptimum(FullComparison* a, FullComparison* b) {
  const double optimum = std::min(a->optimum, b->optimum);
  for (FullComparison* comparison : {a, b}) {
    comparison->optimum = optimum;
    comparison->gap_percent = GapPercent(comparison->cost, optimum, comparison->edges);
  }
}

template <typename G>
hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<G>& optimizer,
                                             const LossChoice& loss) {
  const hpgo::PoseGraph<G> estimate = optimizer.ToGraph();
  return Compare<G>(optimizer, loss, estimate,
                    {{"estimate", hpgo::InitMethod::kFile, &estimate},
                     {"chordal", hpgo::InitMethod::kChordal, &estimate}},
                    nullptr);
}

template <typename G>
hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<G>& optimizer,
                                             const LossChoice& loss,
                                             hpgo::PoseGraph<G>* reference) {
  const hpgo::PoseGraph<G> estimate = optimizer.ToGraph();
  return Compare<G>(optimizer, loss, estimate,
                    {{"estimate", hpgo::InitMethod::kFile, &estimate},
                     {"reference", hpgo::InitMethod::kFile, reference}},
                    reference);
}

template <typename G>
hpgo::Result<ReferenceError> CompareWithReference(const hpgo::PoseGraph<G>& estimate,
                                                  const std::string& name,
                                                  const PoseSource& reference) {
  PoseSource source;
  source.name = name;
  source.trajectory = hpgo::ToTrajectory(estimate);
  const hpgo::Result<PoseMatches> matches = MatchPoses(source, reference);
  if (!matches.ok()) return matches.status();
  const std::vector<SE3>&poses = source.trajectory.poses, &truth = reference.trajectory.poses;
  if (G::kDim == 3 && FLAGS_plane.empty()) return ErrorOfMatched(poses, truth, *matches);
  const hpgo::Result<std::vector<SE2>> planar = PlanarPoses(poses, name);
  if (!planar.ok()) return planar.status();
  const hpgo::Result<std::vector<SE2>> planar_truth = PlanarPoses(truth, reference.name);
  if (!planar_truth.ok()) return planar_truth.status();
  return ErrorOfMatched(*planar, *planar_truth, *matches);
}

template hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<SE2>&,
                                                      const LossChoice&);
template hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<SE3>&,
                                                      const LossChoice&);
template hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<YawPose>&,
                                                      const LossChoice&);
template hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<SE2>&,
                                                      const LossChoice&, hpgo::PoseGraph<SE2>*);
template hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<SE3>&,
                                                      const LossChoice&, hpgo::PoseGraph<SE3>*);
template hpgo::Result<FullComparison> CompareWithFull(const hpgo::Optimizer<YawPose>&,
                                                      const LossChoice&, hpgo::PoseGraph<YawPose>*);
template hpgo::Result<ReferenceError> CompareWithReference(const hpgo::PoseGraph<SE2>&,
                                                           const std::string&, const PoseSource&);
template hpgo::Result<ReferenceError> CompareWithReference(const hpgo::PoseGraph<SE3>&,
                                                           const std::string&, const PoseSource&);

}  // namespace hpgo_cli
