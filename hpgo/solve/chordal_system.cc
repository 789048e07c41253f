#include "hpgo/solve/chordal_system.h"

#include <algorithm>

#include "Eigen/OrderingMethods"

namespace hpgo {

template <int d>
ChordalSystem<d>::ChordalSystem(int unknowns, const std::vector<std::pair<int, int>>& pairs)
    : rank_(unknowns), diagonal_(unknowns) {
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(2 * pairs.size() + unknowns);
  for (int i = 0; i < unknowns; ++i) entries.emplace_back(i, i, 1.0);
  for (const auto& [i, j] : pairs) {
    entries.emplace_back(i, j, 1.0);
    entries.emplace_back(j, i, 1.0);
  }
  Eigen::SparseMatrix<double> pattern(unknowns, unknowns);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::AMDOrdering<int>::PermutationType order;
  Eigen::AMDOrdering<int>()(pattern, order);
  for (int r = 0; r < unknowns; ++r) rank_[order.indices()(r)] = r;
}

template <int d>
void ChordalSystem<d>::Reset(int columns) {
  std::fill(diagonal_.begin(), diagonal_.end(), Block::Zero());
  lower_.clear();
  right_.setZero(d * static_cast<Eigen::Index>(rank_.size()), columns);
}

template <int d>
void ChordalSystem<d>::AddOffDiagonal(int i, int j, const Block& block) {
  const bool below = rank_[i] > rank_[j];
  const int row = d * rank_[below ? i : j], column = d * rank_[below ? j : i];
  for (int r = 0; r < d; ++r) {
    for (int c = 0; c < d; ++c) {
      lower_.emplace_back(row + r, column + c, below ? block(r, c) : block(c, r));
    }
  }
}

template <int d>
bool ChordalSystem<d>::Solve() {
  for (int k = 0; k < static_cast<int>(diagonal_.size()); ++k) {
    for (int r = 0; r < d; ++r) {
      for (int c = 0; c <= r; ++c) lower_.emplace_back(d * k + r, d * k + c, diagonal_[k](r, c));
    }
  }
  Eigen::SparseMatrix<double> matrix(right_.rows(), right_.rows());
  matrix.setFromTriplets(lower_.begin(), lower_.end());
  if (!analyzed_) factorization_.analyzePattern(matrix);
  analyzed_ = true;
  factorization_.factorize(matrix);
  if (factorization_.info() != Eigen::Success) return false;
  right_ = factorization_.solve(right_).eval();
  return right_.allFinite();
}

template class ChordalSystem<2>;
template class ChordalSystem<3>;

}  // namespace hpgo
