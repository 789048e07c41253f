#include "hpgo/solve/ceres_solver.h"

#include <chrono>
#include <cmath>
#include <vector>

#include "ceres/iteration_callback.h"
#include "ceres/problem.h"
#include "ceres/solver.h"
#include "hpgo/solve/ceres_poses.h"

namespace hpgo {
namespace {

using ceres_costs::JacobianKind;
using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Ceres minimizes half the objective.
constexpr double kCeresFactor = 2;

// Ends a solve between iterations.
class Watch final : public ceres::IterationCallback {
 public:
  Watch(const SubproblemOptions& options, Clock::time_point begin)
      : options_(options), begin_(begin) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    // That of a rejected step is the cost it would have led to.
    if (summary.iteration == 0 || summary.cost < best_cost_) best_cost_ = summary.cost;
    if (options_.progress && summary.iteration > 0) {
      options_.progress(summary.iteration, kCeresFactor * best_cost_);
    }
    cancelled_ = options_.cancel != nullptr && *options_.cancel;
    accepted_ += summary.iteration > 0 && summary.step_is_successful;
    const bool ended = accepted_ >= options_.max_iterations ||
                       (accepted_ > 0 && SecondsSince(begin_) > options_.max_seconds);
    return cancelled_ || ended ? ceres::SOLVER_TERMINATE_SUCCESSFULLY : ceres::SOLVER_CONTINUE;
  }
  bool cancelled() const { return cancelled_; }

 private:
  const SubproblemOptions& options_;
  const Clock::time_point begin_;
  double best_cost_ = 0;
  int accepted_ = 0;
  bool cancelled_ = false;
};

ceres::Solver::Options SolverOptions(const SubproblemOptions& options) {
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres_options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  ceres_options.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  ceres_options.num_threads = 1;
  ceres_options.logging_type = ceres::SILENT;
  // Rejected steps come on top: a window of one iteration must not end with none. Watch counts.
  constexpr int kMaxRejected = 30;
  ceres_options.max_num_iterations =
      options.max_iterations > 0 ? options.max_iterations + kMaxRejected : 0;
  ceres_options.function_tolerance = options.function_tolerance;
  // The decrease of the cost decides alone: these two have units, and a pose graph's own vary.
  ceres_options.gradient_tolerance = 1e-14;
  ceres_options.parameter_tolerance = 1e-14;
  ceres_options.initial_trust_region_radius = options.initial_trust_region_radius;
  // A factorization that fails without damping is an invalid step, cured by a smaller radius.
  ceres_options.max_num_consecutive_invalid_steps = 30;
  return ceres_options;
}

template <typename G>
class CeresSolver final : public SubproblemSolver<G> {
 public:
  SubproblemSummary Solve(const SubproblemOptions& options, Subproblem<G>* problem) override {
    const Clock::time_point begin = Clock::now();
    SubproblemSummary summary;
    ceres::Problem ceres_problem(CeresPosesOptions());
    summary.status = poses_.Build(*problem, &ceres_problem);
    if (summary.status.ok()) {
      Watch watch(options, begin);
      ceres::Solver::Options ceres_options = SolverOptions(options);
      ceres_options.callbacks.push_back(&watch);
      ceres::Solver::Summary ceres_summary;
      ceres::Solve(ceres_options, &ceres_problem, &ceres_summary);
      Summarize(ceres_summary, watch.cancelled(), &summary);
      if (summary.final_cost < summary.initial_cost) {
        for (int k = 0; k < problem->num_free; ++k) problem->poses[k] = poses_.Pose(k);
      }
    }
    summary.seconds = SecondsSince(begin);
    return summary;
  }

 private:
  static void Summarize(const ceres::Solver::Summary& from, bool cancelled, SubproblemSummary* to) {
    to->initial_cost = kCeresFactor * from.initial_cost;
    to->final_cost = kCeresFactor * from.final_cost;
    to->converged = from.termination_type == ceres::CONVERGENCE;
    for (const ceres::IterationSummary& iteration : from.iterations) {
      if (iteration.iteration == 0) continue;
      ++to->iterations;
      if (!iteration.step_is_successful) {
        to->damped = true;
      } else if (iteration.relative_decrease > 0) {
        to->predicted_decrease +=
            kCeresFactor * iteration.cost_change / iteration.relative_decrease;
      }
    }
    if (!from.IsSolutionUsable() || !std::isfinite(from.final_cost)) {
      to->final_cost = to->initial_cost;
      to->status = Status(StatusCode::kNoSolution, from.message);
    } else if (cancelled) {
      to->status = Status(StatusCode::kInterrupted, "cancelled");
    }
  }

  CeresPoses<G> poses_{JacobianKind::kLocal};
};

}  // namespace

template <typename G>
std::unique_ptr<SubproblemSolver<G>> MakeCeresSolver() {
  return std::make_unique<CeresSolver<G>>();
}

template std::unique_ptr<SubproblemSolver<ceres_costs::SE2>> MakeCeresSolver();
template std::unique_ptr<SubproblemSolver<ceres_costs::SE3>> MakeCeresSolver();
template std::unique_ptr<SubproblemSolver<ceres_costs::YawPose>> MakeCeresSolver();

}  // namespace hpgo
