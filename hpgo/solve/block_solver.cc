#include "hpgo/solve/block_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "ceres_costs/finite.h"
#include "ceres_costs/stretched_edge.h"
#include "hpgo/chains/span.h"
#include "hpgo/solve/block_system.h"
#include "hpgo/solve/damping.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;
using Clock = std::chrono::steady_clock;

// A few degrees before the half turn, steps grow short.
template <typename G>
bool IsHalfTurn(const G& deviation) {
  return std::cos(deviation.angle() / 2) < 0.05;
}
bool IsHalfTurn(const SE3& deviation) { return std::abs(deviation.rotation().w()) < 0.05; }

template <typename G>
class BlockSolver : public SubproblemSolver<G> {
 public:
  SubproblemSummary Solve(const SubproblemOptions& options, Subproblem<G>* problem) override {
    const Clock::time_point start = Clock::now();
    const auto seconds = [&] {
      return std::chrono::duration<double>(Clock::now() - start).count();
    };
    const auto negligible = [&](double cost) {
      return std::max(options.function_tolerance * std::abs(cost),
                      kRoundingOfAFactor * static_cast<double>(problem->factors.size()));
    };
    SubproblemSummary summary;
    problem_ = problem;
    system_.Analyze(problem);
    hessian_ = Hessian::kHeld;
    // A radius of 1e8 and above is an undamped first step.
    double damping =
        options.initial_trust_region_radius >= 1e8 ? 0 : 1 / options.initial_trust_region_radius;
    double cost = Linearize();
    summary.initial_cost = summary.final_cost = cost;
    if (!std::isfinite(cost)) {
      summary.status = Status(StatusCode::kNoSolution, "the cost is not finite at the start");
      summary.seconds = seconds();
      return summary;
    }
    const std::vector<G> original(problem->poses.begin(),
                                  problem->poses.begin() + problem->num_free);
    bool stalled = false;  // the last step gained next to nothing
    while (summary.iterations < options.max_iterations && problem->num_free > 0) {
      if (options.cancel != nullptr && *options.cancel) {
        summary.status = Status(StatusCode::kInterrupted, "cancelled");
        break;
      }
      if (summary.iterations > 0 && seconds() > options.max_seconds) break;
      ++summary.iterations;
      const StepResult step = Step(cost, &damping, &summary);
      if (!(cost - step.cost > negligible(cost)) && step.promised > negligible(cost) &&
          CrossHalfTurn(options, negligible, &cost, &summary)) {
        continue;
      }
      if (!step.accepted) {
        summary.converged = step.promised <= negligible(cost);
        break;
      }
      const double decrease = cost - step.cost;
      cost = step.cost;
      if (step.full) hessian_ = Hessian::kHeld;
      summary.predicted_decrease += step.predicted;
      if (options.progress) options.progress(summary.iterations, cost);
      const bool stalled_before = std::exchange(stalled, decrease <= negligible(cost));
      if (stalled && (step.damping == 0 || stalled_before)) {
        summary.converged = true;
        break;
      }
      if (stalled) damping = 0;  // which may have held back what is left to gain
      if (summary.iterations < options.max_iterations) Linearize();
    }
    for (int k = 0; k < problem->num_free; ++k) {
      if (IsFinite(problem->poses[k])) continue;
      std::copy(original.begin(), original.end(), problem->poses.begin());
      cost = summary.initial_cost;
      summary.status = Status(StatusCode::kNoSolution, "a pose became infinite");
      break;
    }
    summary.final_cost = cost;
    summary.seconds = seconds();
    return summary;
  }

 private:
  using Vector = typename BlockSystem<G>::Vector;

  struct StepResult {
    bool accepted = false;
    bool full = false;  // neither shortened nor damped
    double cost = 0;
    double predicted = 0;
    double damping = 0;  // of the accepted step
    // The decrease predicted for the least damped step that could be computed.
    double promised = std::numeric_limits<double>::infinity();
  };

  double Linearize() { return system_.Linearize(hessian_); }

  // Once Gauss-Newton has gone too far, stretched edges have their own model, until a full step
  // with it does. Near an optimum Gauss-Newton is the nearer of the two.
  bool TakeStretchedModel() {
    const auto is_stretched = [this](const Factor<G>& factor) {
      return factor.i != kWorldFrame && IsStretched(factor, RelativePose(factor, problem_->poses));
    };
    const auto& factors = problem_->factors;
    if (hessian_ == Hessian::kHeldStretched ||
        std::none_of(factors.begin(), factors.end(), is_stretched)) {
      return false;
    }
    hessian_ = Hessian::kHeldStretched;
    Linearize();
    return true;
  }

  // The Gauss-Newton step; where that overshoots a shorter one, which costs no factorization; then
  // more and more damping until the cost falls.
  StepResult Step(double cost, double* damping, SubproblemSummary* summary) {
    StepResult result;
    while (*damping <= kMaxDamping) {
      if (*damping > 0) summary->damped = true;
      const bool factorized = system_.Factorize(*damping);
      if (factorized) {
        const double promised = FindStep(*damping);
        if (std::isinf(result.promised)) result.promised = promised;
        const double length = std::min(1., kReach / LargestTurn(*problem_, step_));
        if (length < 1 && TakeStretchedModel()) continue;
        summary->damped |= length < 1;
        const double expected = promised * (2 * length - length * length);
        if (Try(length, cost, expected, &result)) {
          result.full = length == 1 && *damping == 0;
          result.damping = *damping;
          *damping = LessDamping(*damping, (cost - result.cost) / expected);
          return result;
        }
        if (TakeStretchedModel()) continue;
        if (*damping == 0 && std::isfinite(result.cost)) {
          summary->damped = true;
          const double t = length * BestStepLength(expected, result.cost - cost);
          if (t > kShortestStep && Try(t, cost, promised * (2 * t - t * t), &result)) return result;
        }
      }
      *damping = factorized ? ShrinkingDamping(*damping) : DampingToFactorize(*damping);
    }
    return result;
  }

  // Of an edge at the half turn, where its error jumps.
  bool StandsAtHalfTurn(const Factor<G>& factor) const {
    if (factor.custom != nullptr) return false;
    const G T = RelativePose(factor, problem_->poses);
    return IsHalfTurn(
        factor.term->measurement.Between(factor.offset == nullptr ? T : G(T * *factor.offset)));
  }

  // The cost has a cliff where an edge stands at the half turn: a step across it looks bad, though
  // what lies beyond may be lower. Takes the step, and stays if a few more end below where it
  // began; else all is as it was.
  template <typename Negligible>
  bool CrossHalfTurn(const SubproblemOptions& options, const Negligible& negligible, double* cost,
                     SubproblemSummary* summary) {
    constexpr int kMostIterations = 20;
    const auto& factors = problem_->factors;
    if (std::none_of(factors.begin(), factors.end(),
                     [&](const Factor<G>& factor) { return StandsAtHalfTurn(factor); })) {
      return false;
    }
    const std::vector<G> before = problem_->poses;
    Linearize();
    double damping = kUsefulDamping;
    bool lower = false;
    if (system_.Factorize(damping)) {
      FindStep(damping);
      for (int k = 0; k < problem_->num_free; ++k) {
        const Vector d(&step_[static_cast<std::size_t>(k) * G::kDof]);
        problem_->poses[k] = problem_->poses[k].Plus(d);
      }
      double beyond = Linearize();
      SubproblemSummary unused;
      for (int k = 0; k < kMostIterations && std::isfinite(beyond); ++k) {
        if (options.cancel != nullptr && *options.cancel) break;
        const StepResult step = Step(beyond, &damping, &unused);
        if (!step.accepted) break;
        const double decrease = beyond - step.cost;
        beyond = step.cost;
        Linearize();
        if (decrease <= negligible(beyond)) break;
      }
      lower = *cost - beyond > negligible(*cost);
      if (lower) {
        summary->predicted_decrease += *cost - beyond;
        *cost = beyond;
      }
    }
    if (!lower) {
      problem_->poses = before;
      Linearize();
    }
    summary->damped = true;
    return lower;
  }

  // Sets step_, the minimum of the damped quadratic model; returns how much the undamped one
  // decreases.
  double FindStep(double damping) {
    std::vector<double>& gradient = system_.gradient();
    step_.resize(gradient.size());
    for (std::size_t k = 0; k < step_.size(); ++k) step_[k] = -gradient[k];
    system_.Solve(step_.data());
    double descent = 0, scaled = 0;  // -g'd and d' diag(H) d
    for (int k = 0; k < problem_->num_free; ++k) {
      const std::size_t at = static_cast<std::size_t>(k) * G::kDof;
      const Vector d(&step_[at]);
      descent -= d.dot(Vector(&gradient[at]));
      scaled += d.dot(system_.Diagonal(k).diagonal().cwiseProduct(d));
    }
    return descent + damping * scaled;
  }

  // Moves the poses by a part of step_ if the cost falls.
  bool Try(double part, double cost, double predicted, StepResult* result) {
    trial_ = problem_->poses;
    for (int k = 0; k < problem_->num_free; ++k) {
      const Vector d(&step_[static_cast<std::size_t>(k) * G::kDof]);
      trial_[k] = problem_->poses[k].Plus(part * d);
    }
    result->predicted = predicted;
    result->cost = system_.Cost(trial_);
    // Rounding hides a decrease of this size: take the step as it is.
    const double noise = 1e-14 * cost;
    result->accepted = result->cost < cost || (result->cost <= cost + noise && predicted <= noise);
    if (result->accepted) problem_->poses.swap(trial_);
    return result->accepted;
  }

  // After a step that was of no use.
  double ShrinkingDamping(double damping) {
    scaled_.resize(step_.size());
    double squared = 0;
    for (int k = 0; k < problem_->num_free; ++k) {
      const std::size_t at = static_cast<std::size_t>(k) * G::kDof;
      const Vector d(&step_[at]);
      Vector scaled(&scaled_[at]);
      scaled = system_.Diagonal(k).diagonal().cwiseProduct(d);
      squared += scaled.dot(d);
    }
    shifted_ = scaled_;
    system_.Solve(shifted_.data());
    double slope = 0;  // d' D (H + damping D)^-1 D d
    for (std::size_t k = 0; k < scaled_.size(); ++k) slope += scaled_[k] * shifted_[k];
    return DampingToShrink(damping, squared, slope);
  }

  Subproblem<G>* problem_ = nullptr;
  BlockSystem<G> system_;
  Hessian hessian_ = Hessian::kHeld;  // changes from step to step
  std::vector<double> step_;
  std::vector<double> scaled_, shifted_;  // workspace of ShrinkingDamping
  std::vector<G> trial_;
};

}  // namespace

template <typename G>
std::unique_ptr<SubproblemSolver<G>> MakeBlockSolver() {
  return std::make_unique<BlockSolver<G>>();
}

template std::unique_ptr<SubproblemSolver<SE2>> MakeBlockSolver();
template std::unique_ptr<SubproblemSolver<SE3>> MakeBlockSolver();
template std::unique_ptr<SubproblemSolver<YawPose>> MakeBlockSolver();

}  // namespace hpgo
