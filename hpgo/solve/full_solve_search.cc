// A full solve: the search over other starts, after the first run has ended.

#include <algorithm>
#include <utility>

#include "ceres_costs/relative_pose_error.h"
#include "hpgo/solve/full_solve_impl.h"

namespace hpgo {
namespace {

// In evaluations of a factor. What the runs after the first may take in all: less than a second; a
// few where their ends differ; or so often what the first took where chi2 per degree of freedom is
// above kSuspicious.
constexpr double kSearchWork = 3e5;
constexpr double kDisagreeingWork = 1e6;
constexpr double kSuspicious = 5;
constexpr double kSuspiciousShare = 4;
constexpr int kSearchIterations = 50;  // of such a run, at least
constexpr int kEnoughSame = 3;
constexpr int kMostGuesses = 12;  // made anew

}  // namespace

template <typename G>
bool FullSolve<G>::IsSuspicious() const {
  const double freedom = static_cast<double>(G::kDof) *
                         (static_cast<double>(NumFactors()) - problem_->subproblem()->num_free);
  return freedom > 0 && report_.cost_after > kSuspicious * freedom;
}

// How many of the runs ended at the lowest cost.
template <typename G>
int FullSolve<G>::Agreeing() const {
  return static_cast<int>(std::count_if(
      report_.candidates.begin(), report_.candidates.end(), [this](const InitCandidate& candidate) {
        return candidate.solved && Same(candidate.end_cost, report_.cost_after);
      }));
}

// Runs other starts while that is worth it. Only a cancellation is an error: a start that fails
// is none.
template <typename G>
Status FullSolve<G>::SearchFurther() {
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

template <typename G>
double FullSolve<G>::StartCost() const {
  const auto solved = std::find_if(report_.candidates.begin(), report_.candidates.end(),
                                   [](const InitCandidate& candidate) { return candidate.solved; });
  return solved->cost;
}

// How far each edge is to be believed, from its error at the best poses so far.
template <typename G>
std::vector<double> FullSolve<G>::Trust() const {
  std::vector<double> trust;
  for (const GraphEdge<G>& edge : graph_.edges()) {
    const G T_i_j = best_[edge.i].Between(best_[edge.j]);
    const typename G::Tangent e =
        DeviationError(options_.convention, edge.measurement.Normalized().Between(T_i_j));
    trust.push_back(1 / (1 + e.dot(edge.information * e) / G::kDof));
  }
  return trust;
}

template class FullSolve<SE2>;
template class FullSolve<SE3>;
template class FullSolve<YawPose>;

}  // namespace hpgo
