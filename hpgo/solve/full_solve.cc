#include "hpgo/solve/full_solve.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "ceres_costs/losses.h"
#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/components.h"
#include "hpgo/graph/edge_classes.h"
#include "hpgo/graph/validate.h"
#include "hpgo/solve/full_problem.h"
#include "hpgo/solve/graduated_loss.h"
#include "hpgo/solve/solver_factory.h"
#include "hpgo/solve/undetermined.h"

namespace hpgo {
namespace {

using Clock = std::chrono::steady_clock;

// In evaluations of a factor. A run to the end takes no more, though any run may take so many
// iterations.
constexpr double kMostWork = 3e8;
constexpr int kAnyIterations = 200;
// What the runs after the first may take in all: less than a second; a few where their ends differ;
// or so often what the first took where chi2 per degree of freedom is above kSuspicious.
constexpr double kSearchWork = 3e5;
constexpr double kDisagreeingWork = 1e6;
constexpr double kSuspicious = 5;
constexpr double kSuspiciousShare = 4;
constexpr int kSearchIterations = 50;  // of such a run, at least
// Ends that are the same, relative to their cost; where there is next to no error, per factor.
constexpr double kSameEnd = 1e-5;
constexpr double kNoError = 1e-9;
constexpr int kEnoughSame = 3;
constexpr int kMostGuesses = 12;  // made anew

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
  Status Start() {
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

  Status Optimize() {
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

  std::size_t NumFactors() const { return problem_->subproblem()->factors.size(); }

  // As many as so much work allows.
  int Iterations(double work, int at_least) const {
    const double affordable = work / std::max<double>(1, static_cast<double>(NumFactors()));
    return static_cast<int>(
        std::min<double>(options_.max_iterations, std::max<double>(at_least, affordable)));
  }

  std::vector<G> Poses() const {
    std::vector<G> poses;
    for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
      poses.push_back(problem_->pose(i));
    }
    return poses;
  }

  bool Lower(double cost, double than) const {
    return cost < than * (1 - kSameEnd) - kNoError * static_cast<double>(NumFactors());
  }
  bool Same(double a, double b) const { return !Lower(a, b) && !Lower(b, a); }

  // Minimizes one loss after the other from where the problem stands.
  SubproblemSummary Minimize(int max_iterations, bool graduated) {
    SubproblemSummary summary;
    summary.converged = true;  // where nothing is free
    if (problem_->subproblem()->num_free == 0) return summary;
    for (std::size_t k = graduated ? 0 : losses_.size() - 1; k < losses_.size(); ++k) {
      const bool last = k + 1 == losses_.size();
      SubproblemOptions options;
      options.max_iterations = last ? max_iterations : std::min(max_iterations, kAnyIterations);
      options.max_seconds = std::max(0.0, options_.max_seconds - SecondsSince(begin_));
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
  Status RunToEnd(const std::vector<G>& start, int max_iterations, InitCandidate* candidate) {
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

  bool IsSuspicious() const {
    const double freedom = static_cast<double>(G::kDof) *
                           (static_cast<double>(NumFactors()) - problem_->subproblem()->num_free);
    return freedom > 0 && report_.cost_after > kSuspicious * freedom;
  }

  // How many of the runs ended at the lowest cost.
  int Agreeing() const {
    return static_cast<int>(std::count_if(report_.candidates.begin(), report_.candidates.end(),
                                          [this](const InitCandidate& candidate) {
                                            return candidate.solved &&
                                                   Same(candidate.end_cost, report_.cost_after);
                                          }));
  }

  // Runs other starts while that is worth it. Only a cancellation is an error: a start that fails
  // is none.
  Status SearchFurther() {
    const double factors = static_cast<double>(NumFactors());
    const int first = report_.iterations;
    const double suspicious = IsSuspicious() ? kSuspiciousShare * factors * first : 0;
    const auto left = [&] {
      const double most = Agreeing() < report_.runs ? kDisagreeingWork : kSearchWork;
      return std::max(most, suspicious) - factors * (report_.iterations - first);
    };
    const auto go_on = [&] {
      return left() >= factors * std::min(first, kSearchIterations) && Agreeing() < kEnoughSame &&
             SecondsSince(begin_) < options_.max_seconds;
    };
    const auto interrupted = [](const Status& status) {
      return status.code() == StatusCode::kInterrupted;
    };
    std::vector<std::size_t> others;
    for (std::size_t k = 0; k < report_.candidates.size(); ++k) {
      const InitCandidate& candidate = report_.candidates[k];
      const auto same = [&](std::size_t other) {
        return Same(report_.candidates[other].cost, candidate.cost);
      };
      // Odometry is often what the file holds.
      if (candidate.status.ok() && !candidate.solved &&
          std::none_of(others.begin(), others.end(), same) && !Same(candidate.cost, StartCost())) {
        others.push_back(k);
      }
    }
    std::sort(others.begin(), others.end(), [this](std::size_t a, std::size_t b) {
      return report_.candidates[a].cost < report_.candidates[b].cost;
    });
    for (const std::size_t k : others) {
      if (!go_on()) break;
      const Result<InitialGuess<G>> guess = MakeInitialGuess<G>(
          report_.candidates[k].method, graph_, [](const std::vector<G>&) { return 0.; },
          options_.cancel);
      if (!guess.ok()) continue;
      const Status status =
          RunToEnd(guess->poses, Iterations(left(), kSearchIterations), &report_.candidates[k]);
      if (interrupted(status)) return status;
    }
    for (int turn = 1; turn <= kMostGuesses && go_on(); ++turn) {
      InitCandidate candidate;
      candidate.method = InitMethod::kJointChordal;
      const Clock::time_point begin = Clock::now();
      const Result<std::vector<G>> guess =
          AnotherGuess(graph_, turn % 2 == 1 ? std::vector<double>() : Trust(), turn);
      if (!guess.ok()) continue;
      problem_->SetPoses(*guess);
      candidate.cost = problem_->Cost();
      candidate.seconds = SecondsSince(begin);
      const Status status = RunToEnd(*guess, Iterations(left(), kSearchIterations), &candidate);
      report_.candidates.push_back(candidate);
      if (interrupted(status)) return status;
    }
    return Status::Ok();
  }

  double StartCost() const {
    const auto solved =
        std::find_if(report_.candidates.begin(), report_.candidates.end(),
                     [](const InitCandidate& candidate) { return candidate.solved; });
    return solved->cost;
  }

  // How far each edge is to be believed, from its error at the best poses so far.
  std::vector<double> Trust() const {
    std::vector<double> trust;
    for (const GraphEdge<G>& edge : graph_.edges()) {
      const G T_i_j = best_[edge.i].Between(best_[edge.j]);
      const typename G::Tangent e =
          DeviationError(options_.convention, edge.measurement.Normalized().Between(T_i_j));
      trust.push_back(1 / (1 + e.dot(edge.information * e) / G::kDof));
    }
    return trust;
  }

  void NoteUndetermined() {
    problem_->SetPoses(best_);
    std::vector<bool> undetermined(graph_.nodes().size(), false);
    for (const int slot : FindUndetermined(*problem_->subproblem())) undetermined[slot] = true;
    for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
      if (undetermined[problem_->slot(i)]) report_.undetermined.push_back(graph_.nodes()[i].id);
    }
  }

  // The best poses become the graph's.
  void Take() {
    for (int i = 0; i < static_cast<int>(graph_.nodes().size()); ++i) {
      GraphNode<G>& node = graph_.node(i);
      if (problem_->is_free(i) || !node.has_pose) node.pose = best_[i];
      node.has_pose = true;
    }
  }

  const FullSolveOptions& options_;
  PoseGraph<G>& graph_;
  const Clock::time_point begin_ = Clock::now();
  FullSolveReport report_;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses_;  // graduated; the last is what counts
  std::unique_ptr<SubproblemSolver<G>> solver_;
  std::unique_ptr<FullProblem<G>> problem_;
  std::vector<G> start_, best_;  // by node; best_ is empty before the first run has ended
};

}  // namespace

template <typename G>
FullSolveReport SolveFull(const FullSolveOptions& options, PoseGraph<G>* graph) {
  return FullSolve<G>(options, graph).Run();
}

template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<SE2>*);
template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<SE3>*);
template FullSolveReport SolveFull(const FullSolveOptions&, PoseGraph<YawPose>*);

}  // namespace hpgo
