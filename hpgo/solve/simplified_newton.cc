#include "hpgo/solve/simplified_newton.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <queue>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "ceres_costs/finite.h"
#include "hpgo/chains/span.h"
#include "hpgo/solve/damping.h"

namespace hpgo {

using ceres_costs::QuadraticModel;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
bool SimplifiedNewton<G>::Begin(const Subproblem<G>& problem, const std::vector<Index>& names) {
  num_slots_ = problem.num_free;
  slot_of_name_.assign(*std::max_element(names.begin(), names.end()) + 1, -1);
  for (int k = 0; k < num_slots_; ++k) slot_of_name_[names[k]] = k;
  system_.Analyze(&problem);
  if (!std::isfinite(system_.Linearize(Hessian::kHeldStretched))) return false;
  system_.BeginFactorizing(0);
  return true;
}

template <typename G>
bool SimplifiedNewton<G>::Resume() {
  const bool fits = std::all_of(slot_of_name_.begin(), slot_of_name_.end(),
                                [this](int slot) { return slot >= -1 && slot < num_slots_; });
  if (!fits || !system_.Resume() || system_.num_rows() != num_slots_) return false;
  system_.BeginFactorizing(0);
  return true;
}

// False if no pose of the system is free in the problem.
template <typename G>
bool SimplifiedNewton<G>::FindSlots(const Subproblem<G>& problem) {
  slots_.assign(problem.num_free, -1);
  bool any = false;
  for (int k = 0; k < problem.num_free; ++k) {
    const Index name = (*names_)[k];
    if (name < static_cast<Index>(slot_of_name_.size())) slots_[k] = slot_of_name_[name];
    any |= slots_[k] >= 0;
  }
  return any;
}

// Sets step_; returns the cost, NaN where one fails. `promised`: the decrease of the model.
template <typename G>
double SimplifiedNewton<G>::FindStep(const Subproblem<G>& problem, double* promised) {
  constexpr int D = G::kDof;
  using Vector = Eigen::Map<Tangent>;
  const auto part = [&](int k) { return Vector(&step_[static_cast<std::size_t>(k) * D]); };
  const auto at = [&](int s) { return Vector(&solution_[static_cast<std::size_t>(s) * D]); };
  // The descent first.
  step_.assign(static_cast<std::size_t>(problem.num_free) * D, 0.);
  double cost = 0;
  QuadraticModel<G> at_j, at_i;
  for (const Factor<G>& factor : problem.factors) {
    const G Y = RelativePose(factor, problem.poses);
    if (!LinearizeFactor(factor, factor.i == kWorldFrame, Y, &at_j)) return std::nan("");
    cost += at_j.cost;
    if (factor.j < problem.num_free) part(factor.j) -= at_j.b;
    if (factor.i == kWorldFrame || factor.i >= problem.num_free) continue;
    TransportModel(Y.Inverse(), at_j, &at_i);  // J_i = -J_j Ad(Y^-1)
    part(factor.i) += at_i.b;
  }
  // What pulls at a follower pulls at its leader: else a component that nothing else holds would be
  // pulled away by those that come along.
  for (auto follower = followers_.rbegin(); follower != followers_.rend(); ++follower) {
    part(follower->leader) +=
        follower->T_leader_pose.InverseAdjoint().transpose() * part(follower->pose);
  }
  solution_.assign(static_cast<std::size_t>(num_slots_) * D, 0.);
  for (int k = 0; k < problem.num_free; ++k) {
    if (slots_[k] >= 0) at(slots_[k]) = part(k);
  }
  system_.Solve(solution_.data());
  *promised = 0;
  for (int k = 0; k < problem.num_free; ++k) {
    if (slots_[k] >= 0) {
      *promised += at(slots_[k]).dot(part(k));
      part(k) = at(slots_[k]);
    } else {
      part(k).setZero();
    }
  }
  for (const Follower& follower : followers_) {
    part(follower.pose) = follower.T_leader_pose.InverseAdjoint() * part(follower.leader);
  }
  return cost;
}

// Poses that are new go with the neighbour that they fit best, rigidly: along a minimum spanning
// forest.
template <typename G>
void SimplifiedNewton<G>::FindFollowers(const Subproblem<G>& problem) {
  struct Link {
    double cost;
    int pose, leader;
    bool operator<(const Link& other) const { return cost > other.cost; }  // the least on top
  };
  followers_.clear();
  const auto is_new = [&](int k) { return k < problem.num_free && slots_[k] < 0; };
  std::unordered_map<int, std::vector<Link>> led;  // by leader
  std::priority_queue<Link> next;
  for (const Factor<G>& factor : problem.factors) {
    if (factor.i == kWorldFrame || !(is_new(factor.i) || is_new(factor.j))) continue;
    const double cost = FactorCost(factor, false, RelativePose(factor, problem.poses));
    for (const auto& [pose, leader] : {std::pair(factor.i, factor.j), {factor.j, factor.i}}) {
      if (!is_new(pose)) continue;
      if (is_new(leader)) {
        led[leader].push_back({cost, pose, leader});
      } else if (leader < problem.num_free) {
        next.push({cost, pose, leader});
      }
    }
  }
  std::unordered_set<int> placed;
  while (!next.empty()) {
    const Link link = next.top();
    next.pop();
    if (!placed.insert(link.pose).second) continue;
    const G T = problem.poses[link.leader].Between(problem.poses[link.pose]);
    followers_.push_back({link.pose, link.leader, T});
    for (const Link& further : led[link.pose]) next.push(further);
  }
}

// Sets trial_; returns its cost, infinite where a pose is.
template <typename G>
double SimplifiedNewton<G>::Try(double part, const Subproblem<G>& problem) {
  trial_ = problem.poses;
  for (int k = 0; k < problem.num_free; ++k) {
    if (slots_[k] < 0) continue;
    const Eigen::Map<Tangent> d(&step_[static_cast<std::size_t>(k) * G::kDof]);
    trial_[k] = problem.poses[k].Plus(part * d);
  }
  for (const Follower& follower : followers_) {
    trial_[follower.pose] = trial_[follower.leader] * follower.T_leader_pose;
  }
  for (int k = 0; k < problem.num_free; ++k) {
    if (!IsFinite(trial_[k])) return std::numeric_limits<double>::infinity();
  }
  return CostAt(problem, trial_);
}

template <typename G>
SubproblemSummary SimplifiedNewton<G>::Solve(const SubproblemOptions& options,
                                             Subproblem<G>* problem) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  SubproblemSummary summary;
  const bool any = FindSlots(*problem);
  FindFollowers(*problem);
  double promised = 0;
  const double cost = FindStep(*problem, &promised);
  summary.initial_cost = summary.final_cost = cost;
  if (!std::isfinite(cost)) {
    summary.status = Status(StatusCode::kNoSolution, "the cost is not finite at the start");
  } else if (options.cancel != nullptr && *options.cancel) {
    summary.status = Status(StatusCode::kInterrupted, "cancelled");
  } else if (any) {
    summary.iterations = 1;
    double length = std::min(1., kReach / LargestTurn(*problem, step_));
    summary.damped = length < 1;
    const auto expected = [&] { return promised * (2 * length - length * length); };
    double trial_cost = Try(length, *problem);
    while (!(trial_cost < cost) && std::isfinite(trial_cost) && length > kShortestStep) {
      summary.damped = true;
      length *= BestStepLength(expected(), trial_cost - cost);
      trial_cost = Try(length, *problem);
    }
    if (trial_cost < cost) {
      problem->poses.swap(trial_);
      summary.final_cost = trial_cost;
      summary.predicted_decrease = expected();
    }
  }
  summary.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return summary;
}

template class SimplifiedNewton<SE2>;
template class SimplifiedNewton<SE3>;
template class SimplifiedNewton<YawPose>;

}  // namespace hpgo
