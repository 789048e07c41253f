#include "hpgo/solve/chordal_system.h"

#include <algorithm>

namespace hpgo {

template <int d>
ChordalSystem<d>::ChordalSystem(int unknowns, const std::vector<std::pair<int, int>>& pairs)
    : unknowns_(unknowns), block_of_(pairs.size()), transposed_(pairs.size()) {
  std::vector<std::pair<int, int>> distinct;
  distinct.reserve(pairs.size());
  for (const auto& [i, j] : pairs) distinct.emplace_back(std::min(i, j), std::max(i, j));
  const std::vector<std::pair<int, int>> ordered = distinct;  // by pair, smaller first
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const auto found = std::lower_bound(distinct.begin(), distinct.end(), ordered[p]);
    block_of_[p] = static_cast<int>(found - distinct.begin());
    transposed_[p] = pairs[p].first > pairs[p].second;
  }
  cholesky_.Analyze(unknowns, distinct);
}

template <int d>
void ChordalSystem<d>::Reset(int columns) {
  cholesky_.SetZero();
  right_.setZero(kStride * static_cast<Eigen::Index>(unknowns_), columns);
  for (int i = 0; i < unknowns_; ++i) {
    for (int k = d; k < kStride; ++k) Eigen::Map<Padded>(cholesky_.Diagonal(i))(k, k) = 1;
  }
}

template <int d>
void ChordalSystem<d>::AddDiagonal(int unknown, const Block& block) {
  Eigen::Map<Padded>(cholesky_.Diagonal(unknown)).template topLeftCorner<d, d>() += block;
}

template <int d>
void ChordalSystem<d>::AddOffDiagonal(int p, const Block& block) {
  Eigen::Map<Padded> stored(cholesky_.OffDiagonal(block_of_[p]));
  if (transposed_[p]) {
    stored.template topLeftCorner<d, d>() += block.transpose();
  } else {
    stored.template topLeftCorner<d, d>() += block;
  }
}

template <int d>
bool ChordalSystem<d>::Solve() {
  if (!cholesky_.Factor(0)) return false;
  for (Eigen::Index c = 0; c < right_.cols(); ++c) cholesky_.Solve(right_.col(c).data());
  return right_.allFinite();
}

template class ChordalSystem<2>;
template class ChordalSystem<3>;
template class ChordalSystem<4>;

}  // namespace hpgo
