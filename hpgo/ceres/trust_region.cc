#include "hpgo/ceres/trust_region.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "hpgo/ceres/progress.h"
#include "hpgo/ceres/secant_pairs.h"
#include "hpgo/solve/damping.h"

namespace hpgo {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Shares of what a step promises. A Gauss-Newton step that gains more says that the matrix is too
// stiff: from there on pairs are kept. Elsewhere such steps converge faster than any learnt from.
constexpr double kTooStiff = 1.05;
// A step with what was learnt that gains less leads where the model is another: nothing is learnt.
constexpr double kLeastShareToLearn = 0.5;
// A step that takes a larger share of the cost is still on its way: what it says of the curvature
// does not hold where it ends.
constexpr double kOnItsWay = 0.1;

class Minimizer {
 public:
  Minimizer(const ceres::Solver::Options& options, PoseSystem* system,
            ceres::Solver::Summary* summary)
      : options_(options), system_(*system), summary_(*summary) {}

  bool Run() {
    const double fixed_cost = system_.FixedCost();
    if (!std::isfinite(fixed_cost) || !Linearize()) return false;
    fixed_cost_ = summary_.fixed_cost = fixed_cost;
    summary_.initial_cost = cost_ + fixed_cost;
    summary_.iterations.clear();
    summary_.num_successful_steps = summary_.num_unsuccessful_steps = 0;
    iteration_.step_is_valid = iteration_.step_is_successful = true;
    iteration_.trust_region_radius = Radius();
    iteration_.cost = cost_ + fixed_cost;
    NoteGradient();
    while (GoOn()) {
      Step();
    }
    summary_.final_cost = cost_ + fixed_cost;
    if (summary_.termination_type == ceres::USER_FAILURE) {
      system_.WriteBackInitial();
    } else {
      system_.WriteBack();
    }
    summary_.minimizer_time_in_seconds = SecondsSince(begin_);
    return true;
  }

 private:
  bool Linearize() {
    const Clock::time_point begin = Clock::now();
    cost_ = system_.Linearize();
    summary_.jacobian_evaluation_time_in_seconds += SecondsSince(begin);
    ++summary_.num_jacobian_evaluations;
    return std::isfinite(cost_);
  }

  double Try(double part) {
    const Clock::time_point begin = Clock::now();
    const double cost = system_.Try(part);
    summary_.residual_evaluation_time_in_seconds += SecondsSince(begin);
    ++summary_.num_residual_evaluations;
    return cost;
  }

  double Radius() const {
    return damping_ > 0 ? std::min(1 / damping_, options_.max_trust_region_radius)
                        : options_.max_trust_region_radius;
  }

  void NoteGradient() {
    iteration_.gradient_norm = system_.gradient_norm();
    iteration_.gradient_max_norm = system_.gradient_max_norm();
  }

  bool End(ceres::TerminationType type, const std::string& message) {
    summary_.termination_type = type;
    summary_.message = message;
    return false;
  }

  // Records the iteration, asks the callbacks and looks at the limits.
  bool GoOn() {
    iteration_.iteration_time_in_seconds = SecondsSince(iteration_begin_);
    iteration_.cumulative_time_in_seconds =
        SecondsSince(begin_) + std::max(0., summary_.preprocessor_time_in_seconds);
    summary_.iterations.push_back(iteration_);
    if (iteration_.step_is_successful) {
      ++summary_.num_successful_steps;
      if (options_.update_state_every_iteration) system_.WriteBack();
    } else {
      ++summary_.num_unsuccessful_steps;
    }
    PrintProgress(options_, iteration_);
    for (ceres::IterationCallback* callback : options_.callbacks) {
      const ceres::CallbackReturnType answer = (*callback)(iteration_);
      if (answer == ceres::SOLVER_ABORT) {
        return End(ceres::USER_FAILURE, "User callback returned SOLVER_ABORT.");
      }
      if (answer == ceres::SOLVER_TERMINATE_SUCCESSFULLY) {
        return End(ceres::USER_SUCCESS, "User callback returned SOLVER_TERMINATE_SUCCESSFULLY.");
      }
    }
    if (ended_) return false;
    if (iteration_.gradient_max_norm <= options_.gradient_tolerance) {
      return End(ceres::CONVERGENCE,
                 Format("Gradient tolerance reached. Gradient max norm: %e <= %e",
                        iteration_.gradient_max_norm, options_.gradient_tolerance));
    }
    if (iteration_.iteration >= options_.max_num_iterations) {
      return End(ceres::NO_CONVERGENCE,
                 Format("Maximum number of iterations reached. Number of iterations: %d.",
                        iteration_.iteration));
    }
    if (iteration_.cumulative_time_in_seconds >= options_.max_solver_time_in_seconds) {
      return End(
          ceres::NO_CONVERGENCE,
          Format("Maximum solver time reached. Total solver time: %e >= %e.",
                 iteration_.cumulative_time_in_seconds, options_.max_solver_time_in_seconds));
    }
    return true;
  }

  // Ends after the iteration has been recorded.
  void EndAfter(const std::string& message) {
    ended_ = true;
    End(ceres::CONVERGENCE, message);
  }

  void Step() {
    iteration_begin_ = Clock::now();
    const int number = iteration_.iteration + 1;
    const double gradient_norm = iteration_.gradient_norm;
    const double gradient_max_norm = iteration_.gradient_max_norm;
    iteration_ = ceres::IterationSummary();
    iteration_.iteration = number;
    iteration_.gradient_norm = gradient_norm;
    iteration_.gradient_max_norm = gradient_max_norm;
    iteration_.cost = cost_ + fixed_cost_;
    iteration_.linear_solver_iterations = 1;
    if (!Factorize()) {
      EndAfter("Trust region radius too small: the Hessian is not positive definite.");
      return;
    }
    const bool learnt = damping_ == 0 && !pairs_.empty();
    double promised = learnt ? system_.FindSecantStep(pairs_) : system_.FindStep(damping_);
    iteration_.step_solver_time_in_seconds = SecondsSince(iteration_begin_);
    summary_.linear_solver_time_in_seconds += iteration_.step_solver_time_in_seconds;
    ++summary_.num_linear_solves;
    iteration_.step_is_valid = true;

    double predicted = promised, part = 1;
    double cost = Try(part);
    if (learnt && !IsLower(cost, predicted)) {
      pairs_.Clear();
      predicted = promised = system_.FindStep(damping_);
      cost = Try(part);
    }
    if (!IsLower(cost, predicted) && std::isfinite(cost)) {
      const double shorter = BestStepLength(promised, cost - cost_);
      if (shorter > kShortestStep) {
        part = shorter;
        predicted = promised * (2 * part - part * part);
        cost = Try(part);
      }
    }
    iteration_.cost_change = cost_ - cost;
    iteration_.step_norm = system_.step_norm();
    iteration_.relative_decrease = predicted > 0 ? iteration_.cost_change / predicted : 0;
    const bool successful = IsLower(cost, predicted);
    const double negligible = options_.function_tolerance * (cost_ + fixed_cost_);
    if (successful && iteration_.cost_change <= negligible) {
      EndAfter(Format("Function tolerance reached. |cost_change|/cost: %e <= %e",
                      std::abs(iteration_.cost_change) / (cost_ + fixed_cost_),
                      options_.function_tolerance));
    } else if (!successful && promised <= negligible) {
      EndAfter(Format("Function tolerance reached. No step promises more than %e of the cost",
                      options_.function_tolerance));
    } else if (successful &&
               system_.step_norm() <= options_.parameter_tolerance *
                                          (system_.value_norm() + options_.parameter_tolerance)) {
      EndAfter(Format("Parameter tolerance reached. Step norm: %e, tolerance: %e.",
                      system_.step_norm(), options_.parameter_tolerance));
    }
    const bool learns = successful && Learns();
    if (!learns) pairs_.Clear();
    if (successful) {
      LowerDamping();
      Take(cost, part, learns);
    } else {
      damping_ = system_.ShrinkingDamping(damping_);
      if (!ended_ && damping_ > kMaxDamping) {
        EndAfter(Format("Trust region radius too small: %e.", 1 / damping_));
      }
    }
    iteration_.trust_region_radius = Radius();
  }

  // By Nielsen's rule, and at once where it weighed next to nothing: steps without damping can be
  // learnt from.
  void LowerDamping() {
    constexpr double kNegligible = 0.01;
    const double q = 2 * std::clamp(iteration_.relative_decrease, 0., 1.) - 1;
    damping_ *= std::max(0.1, 1 - q * q * q);
    if (system_.damping_share() < kNegligible) damping_ = 0;
  }

  // Whether the step that was tried says something of the next one.
  bool Learns() const {
    const double least = pairs_.empty() ? kTooStiff : kLeastShareToLearn;
    return damping_ == 0 && iteration_.relative_decrease > least &&
           iteration_.cost_change <= kOnItsWay * cost_;
  }

  bool Factorize() {
    while (!system_.Factorize(damping_)) {
      damping_ = DampingToFactorize(damping_);
      if (damping_ > kMaxDamping) return false;
    }
    return true;
  }

  bool IsLower(double cost, double predicted) const {
    // Rounding hides a decrease of this size: the step is taken as it is.
    const double noise = 1e-14 * (cost_ + fixed_cost_);
    return cost < cost_ || (cost <= cost_ + noise && predicted <= noise);
  }

  void Take(double cost, double part, bool learns) {
    const double before = cost_;
    std::vector<double> gradient, step;
    if (learns) {
      gradient = system_.gradient();
      step = system_.step();
      for (double& d : step) d *= part;
    }
    system_.Accept();
    iteration_.step_is_successful = true;
    iteration_.cost = cost + fixed_cost_;
    if (ended_) {
      cost_ = cost;
      return;
    }
    if (!Linearize()) {
      // Jacobians that fail where the cost does not: nothing to go on with, the last values stand.
      cost_ = std::min(before, cost);
      EndAfter("Residual and Jacobian evaluation failed after a step; it was taken.");
      summary_.termination_type = ceres::NO_CONVERGENCE;
      return;
    }
    NoteGradient();
    if (learns) pairs_.Add(step, gradient, system_.gradient());
  }

  const ceres::Solver::Options& options_;
  PoseSystem& system_;
  ceres::Solver::Summary& summary_;
  const Clock::time_point begin_ = Clock::now();
  Clock::time_point iteration_begin_ = begin_;
  ceres::IterationSummary iteration_;
  double cost_ = 0, fixed_cost_ = 0;
  double damping_ = 0;
  SecantPairs pairs_;
  bool ended_ = false;
};

}  // namespace

bool MinimizeAsCeres(const ceres::Solver::Options& options, PoseSystem* system,
                     ceres::Solver::Summary* summary) {
  summary->jacobian_evaluation_time_in_seconds = summary->residual_evaluation_time_in_seconds = 0;
  summary->linear_solver_time_in_seconds = 0;
  summary->num_jacobian_evaluations = summary->num_residual_evaluations = 0;
  summary->num_linear_solves = 0;
  return Minimizer(options, system, summary).Run();
}

}  // namespace hpgo
