// The Gauss-Newton system of a Subproblem, in blocks.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "hpgo/solve/block_cholesky.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// H of Gauss-Newton: as it is, singular in directions that no factor measures; or held, every
// factor a little stiff in every direction, so that its poses stay as they are to each other there;
// or that with the model of stretched_edge.h where factors are stretched. No optimum moves by that.
enum class Hessian { kAsMeasured, kHeld, kHeldStretched };

// By direction: what A, the Hessian of a factor, measures best of its kind, translation or
// rotation; of the other kind where it measures nothing of one.
template <typename G>
typename G::Tangent BestOfKind(const typename G::Matrix& A) {
  const double translation = A.diagonal().template head<G::kDim>().maxCoeff();
  const double rotation = A.diagonal().template tail<G::kRotationDof>().maxCoeff();
  typename G::Tangent best;
  best.template head<G::kDim>().setConstant(translation > 0 ? translation : rotation);
  best.template tail<G::kRotationDof>().setConstant(rotation > 0 ? rotation : translation);
  return best;
}

// H d = -g with H = sum J' Omega J (see Hessian) and g = sum J' Omega e over the free poses, under
// right perturbations. Keeps its storage between uses. Not synchronized.
template <typename G>
class BlockSystem {
 public:
  static constexpr int D = G::kDof;
  using Progress = typename BlockCholesky<D>::Progress;
  using Block = Eigen::Map<Eigen::Matrix<double, D, D>>;
  using Vector = Eigen::Map<Eigen::Matrix<double, D, 1>>;

  // Finds the structure and orders it. `problem` must outlive this.
  void Analyze(const Subproblem<G>* problem);
  // Fills H and g at the current poses. The cost, NaN where a custom cost fails.
  double Linearize(Hessian hessian);
  // Factors H + damping diag(H); false if that is not positive definite.
  bool Factorize(double damping) { return cholesky_.Factor(damping); }
  // The same in shares; see BlockCholesky.
  void BeginFactorizing(double damping) { cholesky_.BeginFactor(damping); }
  Progress GoOnFactorizing(double multiplications) { return cholesky_.GoOn(multiplications); }
  // Solves with the factor: step holds D numbers a free pose.
  void Solve(double* step) const { cholesky_.Solve(step); }
  // The cost at other poses.
  double Cost(const std::vector<G>& poses) const { return CostAt(*problem_, poses); }

  std::vector<double>& gradient() { return gradient_; }

  std::int64_t factor_size() const { return cholesky_.factor_size(); }

  // What a saved state has of it: H; see BlockCholesky.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.cholesky_);
  }
  bool Resume() { return cholesky_.Resume(); }
  int num_rows() const { return cholesky_.num_rows(); }
  Block Diagonal(int node) { return Block(cholesky_.Diagonal(node)); }

 private:
  bool IsFree(int index) const { return index != kWorldFrame && index < problem_->num_free; }
  void FindPairs();

  const Subproblem<G>* problem_ = nullptr;
  BlockCholesky<D> cholesky_;
  std::vector<std::pair<int, int>> pairs_;  // of free poses with a factor between them
  std::vector<int> pair_of_;                // by factor
  std::vector<int> begin_, order_;          // workspace of FindPairs
  std::vector<double> gradient_;
};

// How far, in rad, a step turns the ends of a factor against each other, at most; D numbers a free
// pose.
template <typename G>
double LargestTurn(const Subproblem<G>& problem, const std::vector<double>& step);

extern template class BlockSystem<ceres_costs::SE2>;
extern template class BlockSystem<ceres_costs::SE3>;
extern template class BlockSystem<ceres_costs::YawPose>;

}  // namespace hpgo
