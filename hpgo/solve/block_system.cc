#include "hpgo/solve/block_system.h"

#include <algorithm>
#include <cmath>

#include "ceres_costs/stretched_edge.h"

namespace hpgo {

using ceres_costs::QuadraticModel;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

// So stiff is a factor at least, of what it measures best of the kind: rounding does not move what
// it leaves open. Relative to the factor's other pose, not to the world: a long chain, which bends
// easily, is not held. One that measures nothing, or whose loss has rejected it, holds nothing.
constexpr double kHold = 1e-14;

}  // namespace

template <typename G>
void BlockSystem<G>::Analyze(const Subproblem<G>* problem) {
  problem_ = problem;
  FindPairs();
  cholesky_.Analyze(problem->num_free, pairs_);
}

template <typename G>
void BlockSystem<G>::FindPairs() {
  const int num_factors = static_cast<int>(problem_->factors.size());
  const auto low = [&](int f) { return std::min(problem_->factors[f].i, problem_->factors[f].j); };
  const auto high = [&](int f) { return std::max(problem_->factors[f].i, problem_->factors[f].j); };
  // Sorted by the lower end by counting, then each short run by the higher.
  begin_.assign(problem_->num_free + 1, 0);
  for (int f = 0; f < num_factors; ++f) {
    if (low(f) != kWorldFrame && IsFree(high(f))) ++begin_[low(f)];
  }
  int sum = 0;
  for (int& b : begin_) sum += std::exchange(b, sum);
  order_.resize(sum);
  for (int f = 0; f < num_factors; ++f) {
    if (low(f) != kWorldFrame && IsFree(high(f))) order_[begin_[low(f)]++] = f;
  }
  pairs_.clear();
  pair_of_.assign(num_factors, -1);
  for (int k = 0, run = 0; k < problem_->num_free; ++k) {
    const int end = begin_[k];  // begin was advanced to the ends
    std::sort(order_.begin() + run, order_.begin() + end,
              [&](int a, int b) { return high(a) != high(b) ? high(a) < high(b) : a < b; });
    for (; run < end; ++run) {
      const std::pair<int, int> pair(high(order_[run]), k);
      if (pairs_.empty() || pairs_.back() != pair) pairs_.push_back(pair);
      pair_of_[order_[run]] = static_cast<int>(pairs_.size()) - 1;
    }
  }
}

template <typename G>
double BlockSystem<G>::Linearize(Hessian hessian) {
  cholesky_.SetZero();
  gradient_.assign(static_cast<std::size_t>(problem_->num_free) * D, 0.);
  double cost = 0;
  QuadraticModel<G> at_j, at_i;
  typename G::Matrix cross;  // row j, column i
  for (std::size_t f = 0; f < problem_->factors.size(); ++f) {
    const Factor<G>& factor = problem_->factors[f];
    const G Y = RelativePose(factor, problem_->poses);
    if (!LinearizeFactor(factor, factor.i == kWorldFrame, Y, &at_j)) return std::nan("");
    cost += at_j.cost;
    if (hessian != Hessian::kAsMeasured) at_j.A.diagonal() += kHold * BestOfKind<G>(at_j.A);
    if (IsFree(factor.j)) {
      Diagonal(factor.j) += at_j.A;
      Vector(&gradient_[static_cast<std::size_t>(factor.j) * D]) += at_j.b;
    }
    if (!IsFree(factor.i)) continue;
    // J_i = -J_j Ad(Y^-1).
    const bool coupled = IsFree(factor.j);
    TransportModel(Y.Inverse(), at_j, &at_i, coupled ? &cross : nullptr);
    Diagonal(factor.i) += at_i.A;
    Vector(&gradient_[static_cast<std::size_t>(factor.i) * D]) -= at_i.b;
    if (hessian == Hessian::kHeldStretched && IsStretched(factor, Y)) {
      typename G::Matrix ii, ji;
      StretchedModel(factor, Y, &ii, &ji);
      Diagonal(factor.i) += ii;
      if (coupled) cross -= ji;
    }
    if (!coupled) continue;
    Block block(cholesky_.OffDiagonal(pair_of_[f]));
    if (factor.j > factor.i) {
      block -= cross;
    } else {
      block -= cross.transpose();
    }
  }
  if (hessian != Hessian::kAsMeasured) {
    for (int k = 0; k < problem_->num_free; ++k) {  // without a factor
      auto diagonal = Diagonal(k).diagonal();
      if (diagonal.isZero(0)) diagonal.setOnes();
    }
  }
  return cost;
}

template <typename G>
double LargestTurn(const Subproblem<G>& problem, const std::vector<double>& step) {
  constexpr int kFirst = G::kDim, kCount = G::kRotationDof;
  using Rotation = Eigen::Matrix<double, kCount, 1>;
  // In the world's frame, where the turns of two ends can be compared.
  const auto turn = [&](int index) -> Rotation {
    if (index == kWorldFrame || index >= problem.num_free) return Rotation::Zero();
    const Rotation own =
        Eigen::Map<const Rotation>(&step[static_cast<std::size_t>(index) * G::kDof + kFirst]);
    if constexpr (kCount == 1) {
      return own;
    } else {
      return problem.poses[index].matrix() * own;
    }
  };
  double largest_sq = 0;
  for (const Factor<G>& factor : problem.factors) {
    largest_sq = std::max(largest_sq, (turn(factor.j) - turn(factor.i)).squaredNorm());
  }
  return std::sqrt(largest_sq);
}

template double LargestTurn(const Subproblem<SE2>&, const std::vector<double>&);
template double LargestTurn(const Subproblem<SE3>&, const std::vector<double>&);
template double LargestTurn(const Subproblem<YawPose>&, const std::vector<double>&);
template class BlockSystem<SE2>;
template class BlockSystem<SE3>;
template class BlockSystem<YawPose>;

}  // namespace hpgo
