// Sparse symmetric positive definite systems with one d x d block per unknown node.
#pragma once

#include <utility>
#include <vector>

#include "Eigen/Core"
#include "hpgo/solve/block_cholesky.h"

namespace hpgo {

// Used as Reset, Add..., Solve, any number of times on one pattern, which is ordered once. Not
// synchronized.
template <int d>
class ChordalSystem {
 public:
  using Block = Eigen::Matrix<double, d, d>;

  // `pairs` are the unknowns that share off-diagonal blocks, first != second; any may come again.
  ChordalSystem(int unknowns, const std::vector<std::pair<int, int>>& pairs);

  // All zero, with `columns` right sides.
  void Reset(int columns);
  // Adds to the diagonal block of an unknown; to the block at row pairs[p].first and column
  // pairs[p].second and, transposed, to its mirror image; to an unknown's rows of the right sides.
  void AddDiagonal(int unknown, const Block& block);
  void AddOffDiagonal(int p, const Block& block);
  template <typename Derived>
  void AddRight(int unknown, const Eigen::MatrixBase<Derived>& rows) {
    right_.middleRows<d>(kStride * unknown) += rows;
  }
  // False if the matrix is not positive definite.
  bool Solve();
  // The solution's rows of an unknown.
  auto Solution(int unknown) const { return right_.middleRows<d>(kStride * unknown); }

 private:
  // The factorization's blocks; rows beyond d are idle.
  static constexpr int kStride = d <= 3 ? 3 : 6;
  using Padded = Eigen::Matrix<double, kStride, kStride>;

  const int unknowns_;
  std::vector<int> block_of_;     // by pair
  std::vector<bool> transposed_;  // by pair: the block is stored the other way round
  BlockCholesky<kStride> cholesky_;
  Eigen::MatrixXd right_;
};

extern template class ChordalSystem<2>;
extern template class ChordalSystem<3>;
extern template class ChordalSystem<4>;

}  // namespace hpgo
