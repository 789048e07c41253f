#include "hpgo/solve/full_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "ceres_costs/losses.h"
#include "hpgo/graph/components.h"
#include "hpgo/graph/edge_classes.h"
#include "hpgo/graph/validate.h"
#include "hpgo/solve/full_problem.h"
#include "hpgo/solve/solver_factory.h"

namespace hpgo {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

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

template <typename G>
class FullSolve {
 public:
  FullSolve(const FullSolveOptions& options, PoseGraph<G>* graph)
      : options_(options), graph_(*graph) {}

  FullSolveReport Run() {
    report_.status = CheckOptions(options_);
    if (report_.status.ok()) report_.status = CheckGraph(graph_);
    if (report_.status.ok()) report_.status = MakeProblem();
    if (report_.status.ok()) report_.status = Start();
    if (report_.status.ok()) report_.status = Optimize();
    report_.seconds = SecondsSince(begin_);
    return std::move(report_);
  }

 private:
  Status MakeProblem() {
    std::string error;
    if (!ceres_costs::MakeLoss(options_.loss, options_.loss_scale, &loss_, &error)) {
      return Status(StatusCode::kInvalidArgument, error);
    }
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
    problem_ =
        std::make_unique<FullProblem<G>>(graph_, held, robust, loss_.get(), options_.convention);
    return Status::Ok();
  }

  // Sets the problem's poses to the initial guess.
  Status Start() {
    const auto cost = [this](const std::vector<G>& poses) {
      problem_->SetPoses(poses);
      return problem_->Cost();
    };
    const Result<InitialGuess<G>> input = MakeInitialGuess<G>(InitMethod::kFile, graph_, cost, {});
    if (!input.ok()) return input.status();
    report_.cost_before = problem_->Cost();
    report_.chi2_before = problem_->Chi2();
    const Result<InitialGuess<G>> guess =
        MakeInitialGuess<G>(options_.init, graph_, cost, options_.cancel);
    if (!guess.ok()) return guess.status();
    problem_->SetPoses(guess->poses);
    report_.init = guess->method;
    report_.candidates = guess->candidates;
    report_.cost_start = problem_->Cost();
    report_.chi2_start = problem_->Chi2();
    report_.init_seconds = SecondsSince(begin_);
    return Status::Ok();
  }

  Status Optimize() {
    SubproblemOptions options;
    options.max_iterations = options_.max_iterations;
    options.max_seconds = std::max(0.0, options_.max_seconds - SecondsSince(begin_));
    options.function_tolerance = options_.function_tolerance;
    options.initial_trust_region_radius = options_.initial_trust_region_radius;
    options.cancel = options_.cancel;
    options.progress = options_.progress;
    SubproblemSummary summary;
    summary.converged = true;  // where nothing is free
    if (problem_->subproblem()->num_free > 0) {
      summary = solver_->Solve(options, problem_->subproblem());
    }
    report_.converged = summary.converged;
    report_.iterations = summary.iterations;
    report_.solve_seconds = summary.seconds;
    if (!summary.status.ok() && summary.status.code() != StatusCode::kInterrupted) {
      return summary.status;
    }
    report_.cost_after = problem_->Cost();
    report_.chi2_after = problem_->Chi2();
    for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
      GraphNode<G>& node = graph_.node(i);
      if (problem_->is_free(i) || !node.has_pose) node.pose = problem_->pose(i);
      node.has_pose = true;
    }
    return summary.status;
  }

  const FullSolveOptions& options_;
  PoseGraph<G>& graph_;
  const Clock::time_point begin_ = Clock::now();
  FullSolveReport report_;
  std::unique_ptr<ceres::LossFunction> loss_;
  std::unique_ptr<SubproblemSolver<G>> solver_;
  std::unique_ptr<FullProblem<G>> problem_;
};

}  // namespace

template <typename G>
FullSolveReport SolveFull(const FullSolveOptions& options, PoseGraph<G>* graph) {
  return FullSolve<G>(options, graph).Run();
}

template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<SE2>*);
template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<SE3>*);

}  // namespace hpgo
