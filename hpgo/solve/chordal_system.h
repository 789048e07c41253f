// Sparse symmetric positive definite systems with one d x d block per unknown node.
#pragma once

#include <utility>
#include <vector>

#include "Eigen/Core"
#include "Eigen/SparseCholesky"
#include "Eigen/SparseCore"

namespace hpgo {

// Used as Reset, Add..., Solve, any number of times on one pattern, which is ordered once and on
// blocks. Not synchronized.
template <int d>
class ChordalSystem {
 public:
  using Block = Eigen::Matrix<double, d, d>;

  // `pairs` are the unknowns that share off-diagonal blocks; each gets one in every use.
  ChordalSystem(int unknowns, const std::vector<std::pair<int, int>>& pairs);

  void Reset(int columns);
  // Adds to the diagonal block, the off-diagonal block (i, j) and its transpose, the right side.
  void AddDiagonal(int i, const Block& block) { diagonal_[rank_[i]] += block; }
  void AddOffDiagonal(int i, int j, const Block& block);
  template <typename Derived>
  void AddRight(int i, const Eigen::MatrixBase<Derived>& block) {
    right_.middleRows<d>(d * rank_[i]) += block;
  }
  // False if the matrix is not positive definite.
  bool Solve();
  // The solution's rows of unknown i.
  auto Solution(int i) const { return right_.middleRows<d>(d * rank_[i]); }

 private:
  std::vector<int> rank_;  // position in the elimination order
  std::vector<Block> diagonal_;
  std::vector<Eigen::Triplet<double>> lower_;
  Eigen::MatrixXd right_;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower, Eigen::NaturalOrdering<int>>
      factorization_;
  bool analyzed_ = false;
};

extern template class ChordalSystem<2>;
extern template class ChordalSystem<3>;

}  // namespace hpgo
