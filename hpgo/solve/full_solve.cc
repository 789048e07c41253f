// A full solve: the problem, its start, a run to the end, and what becomes of the best.

#include "hpgo/solve/full_solve.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ceres_costs/losses.h"
#include "hpgo/graph/components.h"
#include "hpgo/graph/edge_classes.h"
#include "hpgo/graph/validate.h"
#include "hpgo/solve/full_solve_impl.h"
#include "hpgo/solve/graduated_loss.h"
#include "hpgo/solve/solver_factory.h"
#include "hpgo/solve/undetermined.h"

namespace hpgo {
namespace {

// In evaluations of a factor. A run to the end takes no more, though any run may take so many
// iterations.
constexpr double kMostWork = 3e8;
constexpr int kAnyIterations = 200;
// Ends that are the same, relative to their cost; where there is next to no error, per factor.
constexpr double kSameEnd = 1e-5;
constexpr double kNoError = 1e-9;

Status CheckOptions(const FullSolveOptions& options) {
  if (options.max_iterations < 0) {
    return Status(
        StatusCode::kInvalidArgument,
        "max_iterations is " + std::to_string(options.max_iterations) + ", must not be negative");
  }
  if (!(options.max_seconds >= 0)) {
    return Status(
        StatusCode::kInvalidArgument,
        "max_seconds is " + std::to_string(options.max_seconds) + ", must not be negative");
  }
  return Status::Ok();
}

}  // namespace

template <typename G>
FullSolveReport FullSolve<G>::Run() {
  report_.status = CheckOptions(options_);
  if (report_.status.ok()) report_.status = CheckGraph(graph_);
  if (report_.status.ok()) report_.status = MakeProblem();
  if (report_.status.ok()) report_.status = Start();
  if (report_.status.ok()) report_.status = Optimize();
  report_.seconds = SecondsSince(begin_);
  return std::move(report_);
}

template <typename G>
Status FullSolve<G>::MakeProblem() {
  std::string error;
  std::unique_ptr<ceres::LossFunction> loss;
  if (!ceres_costs::MakeLoss(options_.loss, options_.loss_scale, &loss, &error)) {
    return Status(StatusCode::kInvalidArgument, error);
  }
  losses_ = GraduatedLosses(options_.loss, options_.loss_scale);
  solver_ = MakeSolver<G>(options_.engine);
  std::vector<bool> robust = LoopClosures(graph_);
  report_.loop_closures = static_cast<int>(std::count(robust.begin(), robust.end(), true));
  if (options_.loss_on == LossScope::kAllEdges) robust.assign(robust.size(), true);
  const Components components = FindComponents(graph_);
  report_.components = components.count;
  const std::vector<int> held = GaugeNodes(graph_, components);
  report_.held_nodes = static_cast<int>(held.size());
  for (const int node : held) {
    if (!graph_.nodes()[node].fixed) report_.anchored.push_back(graph_.nodes()[node].id);
  }
  problem_ = std::make_unique<FullProblem<G>>(graph_, held, robust, losses_.back().get(),
                                              options_.convention);
  return Status::Ok();
}

// Sets the problem's poses to the initial guess.
template <typename G>
Status FullSolve<G>::Start() {
  const auto cost = [this](const std::vector<G>& poses) {
    problem_->SetPoses(poses);
    return problem_->Cost();
  };
  const Result<InitialGuess<G>> input = MakeInitialGuess<G>(InitMethod::kFile, graph_, cost, {});
  if (!input.ok()) return input.status();
  report_.cost_before = problem_->Cost();
  report_.chi2_before = problem_->Chi2();
  problem_->SetLoss(losses_.front().get());
  const Result<InitialGuess<G>> guess =
      MakeInitialGuess<G>(options_.init, graph_, cost, options_.cancel);
  if (!guess.ok()) return guess.status();
  problem_->SetLoss(losses_.back().get());
  problem_->SetPoses(guess->poses);
  start_ = guess->poses;
  report_.init = guess->method;
  report_.candidates = guess->candidates;
  report_.cost_start = problem_->Cost();
  report_.chi2_start = problem_->Chi2();
  report_.init_seconds = SecondsSince(begin_);
  return Status::Ok();
}

template <typename G>
Status FullSolve<G>::Optimize() {
  const Clock::time_point begin = Clock::now();
  const auto used = std::find_if(
      report_.candidates.begin(), report_.candidates.end(),
      [this](const InitCandidate& candidate) { return candidate.method == report_.init; });
  Status status = RunToEnd(start_, Iterations(kMostWork, kAnyIterations), &*used);
  if (status.ok() && options_.init == InitMethod::kAuto && problem_->subproblem()->num_free > 0 &&
      report_.iterations < options_.max_iterations) {
    status = SearchFurther();
  }
  report_.solve_seconds = SecondsSince(begin);
  if (best_.empty()) return status;
  Take();
  NoteUndetermined();
  return status;
}

// As many as so much work allows.
template <typename G>
int FullSolve<G>::Iterations(double work, int at_least) const {
  const double affordable = work / std::max<double>(1, static_cast<double>(NumFactors()));
  return static_cast<int>(
      std::min<double>(options_.max_iterations, std::max<double>(at_least, affordable)));
}

template <typename G>
std::vector<G> FullSolve<G>::Poses() const {
  std::vector<G> poses;
  for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
    poses.push_back(problem_->pose(i));
  }
  return poses;
}

template <typename G>
bool FullSolve<G>::Lower(double cost, double than) const {
  return cost < than * (1 - kSameEnd) - kNoError * static_cast<double>(NumFactors());
}

// Minimizes one loss after the other from where the problem stands.
template <typename G>
SubproblemSummary FullSolve<G>::Minimize(int max_iterations, bool graduated) {
  SubproblemSummary summary;
  summary.converged = true;  // where nothing is free
  if (problem_->subproblem()->num_free == 0) return summary;
  for (std::size_t k = graduated ? 0 : losses_.size() - 1; k < losses_.size(); ++k) {
    const bool last = k + 1 == losses_.size();
    SubproblemOptions options;
    options.max_iterations = last ? max_iterations : std::min(max_iterations, kAnyIterations);
    options.max_seconds = options_.max_seconds - SecondsSince(begin_);
    if (!(options.max_seconds > 0)) options.max_iterations = 0;
    // On the way an approximate optimum is enough.
    options.function_tolerance =
        last ? options_.function_tolerance : std::max(1e-3, options_.function_tolerance);
    options.initial_trust_region_radius = options_.initial_trust_region_radius;
    options.cancel = options_.cancel;
    if (options_.progress) {
      options.progress = [this, before = report_.iterations](int iteration, double cost) {
        options_.progress(before + iteration, cost);
      };
    }
    problem_->SetLoss(losses_[k].get());
    summary = solver_->Solve(options, problem_->subproblem());
    report_.iterations += summary.iterations;
    if (!summary.status.ok()) break;
  }
  problem_->SetLoss(losses_.back().get());
  return summary;
}

// A run from a start; keeps its end if that is lower than the best so far. Not graduated where
// that ends above the start.
template <typename G>
Status FullSolve<G>::RunToEnd(const std::vector<G>& start, int max_iterations,
                              InitCandidate* candidate) {
  const int before = report_.iterations;
  problem_->SetPoses(start);
  const double start_cost = problem_->Cost(), start_chi2 = problem_->Chi2();
  SubproblemSummary summary = Minimize(max_iterations, true);
  if (losses_.size() > 1 && summary.status.ok() && !(problem_->Cost() <= start_cost)) {
    problem_->SetPoses(start);
    summary = Minimize(max_iterations, false);
  }
  if (summary.status.ok() && !summary.converged && !best_.empty() &&
      Lower(problem_->Cost(), report_.cost_after)) {
    summary = Minimize(Iterations(kMostWork, kAnyIterations),
                       false);  // the work of a search was too little
  }
  candidate->iterations = report_.iterations - before;
  if (!summary.status.ok() && summary.status.code() != StatusCode::kInterrupted) {
    return summary.status;
  }
  candidate->solved = true;
  candidate->end_cost = problem_->Cost();
  ++report_.runs;
  if (best_.empty() || Lower(candidate->end_cost, report_.cost_after)) {
    best_ = Poses();
    report_.init = candidate->method;
    report_.cost_start = start_cost;
    report_.chi2_start = start_chi2;
    report_.cost_after = candidate->end_cost;
    report_.chi2_after = problem_->Chi2();
    report_.converged = summary.converged;
  }
  return summary.status;
}

template <typename G>
void FullSolve<G>::NoteUndetermined() {
  problem_->SetPoses(best_);
  std::vector<bool> undetermined(graph_.nodes().size(), false);
  for (const int slot : FindUndetermined(*problem_->subproblem())) undetermined[slot] = true;
  for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
    if (undetermined[problem_->slot(i)]) report_.undetermined.push_back(graph_.nodes()[i].id);
  }
}

// The best poses become the graph's.
template <typename G>
void FullSolve<G>::Take() {
  for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
    GraphNode<G>& node = graph_.node(i);
    if (problem_->is_free(i) || !node.has_pose) node.pose = best_[i];
    node.has_pose = true;
  }
}

template <typename G>
FullSolveReport SolveFull(const FullSolveOptions& options, PoseGraph<G>* graph) {
  return FullSolve<G>(options, graph).Run();
}

template class FullSolve<SE2>;
template class FullSolve<SE3>;
template class FullSolve<YawPose>;
template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<SE2>*);
template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<SE3>*);
template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<YawPose>*);

}  // namespace hpgo
