// BlockCholesky: the order, the supernodes and the places of a matrix.

#include <algorithm>
#include <set>
#include <utility>

#include "hpgo/solve/block_cholesky.h"
#include "hpgo/solve/dense_kernels.h"
#include "hpgo/solve/elimination_order.h"

namespace hpgo {
namespace {

// Supernodes are merged while the blocks of zeros this adds stay below this share of the panel:
// narrow ones lose more by their overhead than by a few zeros.
double AllowedZeros(int width) { return width <= 4 ? 0.5 : width <= 16 ? 0.15 : 0.05; }

// Wider ones are divided: a share of a factorization ends between two.
constexpr int kWidest = 32;

}  // namespace

template <int kBlock>
void BlockCholesky<kBlock>::Analyze(int n, const std::vector<std::pair<int, int>>& pairs) {
  if (n != n_ || pairs != pairs_) {
    n_ = n;
    pairs_ = pairs;
    Order(pairs);
    FindSupernodes();
    FindRows();
    PlaceValues(pairs);
  }
  SetZero();
}

template <int kBlock>
bool BlockCholesky<kBlock>::Resume() {
  const int n = std::exchange(n_, -1);
  std::vector<std::pair<int, int>> pairs = std::move(pairs_);
  const auto is_row = [n](int i) { return i >= 0 && i < n; };
  std::set<std::pair<int, int>> seen;
  for (const auto& [i, j] : pairs) {
    if (!is_row(i) || !is_row(j) || i == j || !seen.insert(std::minmax(i, j)).second) return false;
  }
  if (n < 0 || values_.size() != (n + pairs.size()) * kBlockSize) return false;
  std::vector<double> values = std::move(values_);
  Analyze(n, pairs);
  values_ = std::move(values);
  return true;
}

template <int kBlock>
void BlockCholesky<kBlock>::Order(const std::vector<std::pair<int, int>>& pairs) {
  EliminationOrder order = FindEliminationOrder(n_, pairs);
  position_ = std::move(order.position);
  parent_ = std::move(order.parent);

  below_begin_.assign(n_ + 1, 0);
  below_.resize(pairs.size());
  for (const auto& [i, j] : pairs) ++below_begin_[std::min(position_[i], position_[j])];
  int sum = 0;
  for (int i = 0; i <= n_; ++i) sum += std::exchange(below_begin_[i], sum);
  std::vector<int> fill(below_begin_.begin(), below_begin_.end() - 1);
  for (const auto& [i, j] : pairs) {
    const auto [low, high] = std::minmax(position_[i], position_[j]);
    below_[fill[low]++] = high;
  }
}

template <int kBlock>
void BlockCholesky<kBlock>::FindSupernodes() {
  // Column counts below the diagonal: each row's subtree of the elimination tree, by marking.
  std::vector<int> count(n_, 0), mark(n_, -1);
  std::vector<int> above_begin(n_ + 1, 0), above(below_.size());
  for (const int row : below_) ++above_begin[row];
  int sum = 0;
  for (int i = 0; i <= n_; ++i) sum += std::exchange(above_begin[i], sum);
  std::vector<int> fill(above_begin.begin(), above_begin.end() - 1);
  for (int column = 0; column < n_; ++column) {
    for (int e = below_begin_[column]; e < below_begin_[column + 1]; ++e) {
      above[fill[below_[e]]++] = column;
    }
  }
  for (int row = 0; row < n_; ++row) {
    mark[row] = row;
    for (int e = above_begin[row]; e < above_begin[row + 1]; ++e) {
      for (int k = above[e]; mark[k] != row; k = parent_[k]) {
        mark[k] = row;
        ++count[k];
      }
    }
  }
  super_begin_.clear();
  double zeros = 0;  // blocks of zeros stored in the supernode being built
  for (int k = 0; k < n_; ++k) {
    bool join = false;
    if (k > 0 && parent_[k - 1] == k) {
      // Joining makes every earlier column of the supernode as long as column k.
      const int width = k - super_begin_.back();
      const double extra = count[k] + 1 - count[k - 1];  // per column, never negative
      const double added = zeros + extra * width;
      const double total = 0.5 * (width + 1.) * (width + 2.) + (width + 1.) * count[k];
      join = width < kWidest && added <= AllowedZeros(width + 1) * total;
      if (join) zeros = added;
    }
    if (!join) {
      super_begin_.push_back(k);
      zeros = 0;
    }
  }
  super_begin_.push_back(n_);
  super_of_.resize(n_);
  for (int s = 0; s + 1 < static_cast<int>(super_begin_.size()); ++s) {
    std::fill(super_of_.begin() + super_begin_[s], super_of_.begin() + super_begin_[s + 1], s);
  }
}

template <int kBlock>
void BlockCholesky<kBlock>::FindRows() {
  const int num = static_cast<int>(super_begin_.size()) - 1;
  rows_begin_.assign(1, 0);
  rows_.clear();
  panel_begin_.clear();
  panel_ld_.clear();
  factor_size_ = 0;
  std::vector<int> mark(n_, -1), first(num, -1), sibling(num, -1);
  for (int s = 0; s < num; ++s) {
    const int end = super_begin_[s + 1];
    for (int k = super_begin_[s]; k < end; ++k) {
      rows_.push_back(k);
      mark[k] = s;
    }
    const std::size_t own = rows_.size();
    const auto add = [&](int row) {
      if (row >= end && mark[row] != s) {
        mark[row] = s;
        rows_.push_back(row);
      }
    };
    for (int e = below_begin_[super_begin_[s]]; e < below_begin_[end]; ++e) add(below_[e]);
    for (int child = first[s]; child >= 0; child = sibling[child]) {
      for (std::int64_t r = rows_begin_[child] + Width(child); r < rows_begin_[child + 1]; ++r) {
        add(rows_[r]);
      }
    }
    std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(own), rows_.end());
    rows_begin_.push_back(static_cast<std::int64_t>(rows_.size()));
    if (rows_.size() > own) {
      const int up = super_of_[rows_[own]];
      sibling[s] = first[up];
      first[up] = s;
    }
    // The padding below each column stays zero, so that kernels may run over it.
    panel_ld_.push_back(RoundUp(Rows(s) * kBlock + kPadding - 1));
    panel_begin_.push_back(factor_size_);
    factor_size_ += static_cast<std::int64_t>(panel_ld_[s]) * Width(s) * kBlock;
  }
}

template <int kBlock>
void BlockCholesky<kBlock>::PlaceValues(const std::vector<std::pair<int, int>>& pairs) {
  targets_.clear();
  targets_.reserve(n_ + pairs.size());
  const auto place = [&](int row, int column, bool transposed) {
    const int s = super_of_[column];
    const auto begin = rows_.begin() + rows_begin_[s], end = rows_.begin() + rows_begin_[s + 1];
    const std::int64_t r = row < super_begin_[s + 1]
                               ? row - super_begin_[s]
                               : std::lower_bound(begin + Width(s), end, row) - begin;
    const std::int64_t c = column - super_begin_[s];
    targets_.push_back(
        {panel_begin_[s] + c * kBlock * panel_ld_[s] + r * kBlock, panel_ld_[s], transposed});
  };
  for (int i = 0; i < n_; ++i) place(position_[i], position_[i], false);
  for (const auto& [i, j] : pairs) {
    const int row = position_[i], column = position_[j];
    place(std::max(row, column), std::min(row, column), row < column);
  }
  values_.resize(targets_.size() * kBlockSize);
  const int num = static_cast<int>(super_begin_.size()) - 1;
  filled_begin_.assign(num + 1, 0);
  const auto super_of = [&](std::size_t v) {
    return v < static_cast<std::size_t>(n_) ? super_of_[position_[v]]
                                            : super_of_[std::min(position_[pairs[v - n_].first],
                                                                 position_[pairs[v - n_].second])];
  };
  for (std::size_t v = 0; v < targets_.size(); ++v) ++filled_begin_[super_of(v)];
  int sum = 0;
  for (int& begin : filled_begin_) sum += std::exchange(begin, sum);
  filled_.resize(targets_.size());
  std::vector<int> fill(filled_begin_.begin(), filled_begin_.end() - 1);
  for (std::size_t v = 0; v < targets_.size(); ++v) {
    filled_[fill[super_of(v)]++] = static_cast<int>(v);
  }
}

template class BlockCholesky<3>;
template class BlockCholesky<4>;
template class BlockCholesky<6>;

}  // namespace hpgo
