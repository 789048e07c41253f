#include "hpgo/solve/block_cholesky.h"

#include <algorithm>
#include <cmath>

#include "hpgo/solve/dense_kernels.h"

namespace hpgo {
namespace {

constexpr double kMinPivotRatio = 1e-14;

}  // namespace

template <int kBlock>
void BlockCholesky<kBlock>::SetZero() {
  std::fill(values_.begin(), values_.end(), 0.);
}

// The panel as it is before anything is subtracted.
template <int kBlock>
void BlockCholesky<kBlock>::FillPanel(int s) {
  std::fill_n(&factor_[panel_begin_[s]],
              static_cast<std::ptrdiff_t>(panel_ld_[s]) * Width(s) * kBlock, 0.);
  for (int k = filled_begin_[s]; k < filled_begin_[s + 1]; ++k) {
    const int v = filled_[k];
    const Target& target = targets_[v];
    const double* value = &values_[static_cast<std::size_t>(v) * kBlockSize];
    double* corner = &factor_[target.offset];
    for (int c = 0; c < kBlock; ++c) {
      for (int r = 0; r < kBlock; ++r, ++value) {
        corner[target.transposed ? r * target.ld + c : c * target.ld + r] = *value;
      }
    }
    if (v >= n_) continue;
    for (int c = 0; c < kBlock; ++c) {
      double& diagonal = corner[static_cast<std::ptrdiff_t>(c) * (target.ld + 1)];
      min_pivot_[static_cast<std::size_t>(position_[v]) * kBlock + c] =
          kMinPivotRatio * std::abs(diagonal);
      diagonal *= 1 + lambda_;
    }
  }
}

// Subtracts from the panel of s the outer product of the descendant's rows from first_row on, of
// which num_columns are columns of s.
template <int kBlock>
void BlockCholesky<kBlock>::Update(int s, int descendant, int first_row, int num_columns) {
  const int num_rows = Rows(descendant) - first_row;
  const int ld = panel_ld_[descendant];
  const double* source = &factor_[panel_begin_[descendant]] + first_row * kBlock;
  const int* row = &rows_[rows_begin_[descendant] + first_row];
  double* panel = &factor_[panel_begin_[s]];
  const int m = num_rows * kBlock, n = num_columns * kBlock, k = Width(descendant) * kBlock;
  if (map_[row[num_rows - 1]] - map_[row[0]] == num_rows - 1) {
    // Contiguous in the panel: no detour.
    const std::ptrdiff_t corner = map_[row[0]] * kBlock;
    SubtractProduct(m, n, k, source, ld, source, ld, panel + corner * panel_ld_[s] + corner,
                    panel_ld_[s]);
    return;
  }
  const int update_ld = RoundUp(m);
  update_.assign(static_cast<std::size_t>(update_ld) * n + kPadding, 0.);
  SubtractProduct(m, n, k, source, ld, source, ld, update_.data(), update_ld);
  for (int c = 0; c < num_columns; ++c) {
    for (int q = 0; q < kBlock; ++q) {
      double* to = panel + static_cast<std::ptrdiff_t>(map_[row[c]] * kBlock + q) * panel_ld_[s];
      const double* from = &update_[static_cast<std::size_t>(c * kBlock + q) * update_ld];
      for (int r = c; r < num_rows; ++r) {
        for (int p = 0; p < kBlock; ++p) to[map_[row[r]] * kBlock + p] += from[r * kBlock + p];
      }
    }
  }
}

// With the supernode of the descendant's next row.
template <int kBlock>
void BlockCholesky<kBlock>::Queue(int descendant) {
  if (next_row_[descendant] >= Rows(descendant)) return;
  const int up = super_of_[rows_[rows_begin_[descendant] + next_row_[descendant]]];
  next_[descendant] = head_[up];
  head_[up] = descendant;
}

template <int kBlock>
void BlockCholesky<kBlock>::BeginFactor(double lambda) {
  const int num = static_cast<int>(super_begin_.size()) - 1;
  lambda_ = lambda;
  if (capacity_ < factor_size_) {
    capacity_ = factor_size_;
    factor_.reset(new double[static_cast<std::size_t>(capacity_)]);
  }
  min_pivot_.resize(static_cast<std::size_t>(n_) * kBlock);
  head_.assign(num, -1);
  next_.assign(num, -1);
  next_row_.assign(num, 0);
  map_.resize(n_);
  super_ = 0;
  if (num > 0) BeginPanel(0);
}

template <int kBlock>
void BlockCholesky<kBlock>::BeginPanel(int s) {
  FillPanel(s);
  for (int r = 0; r < Rows(s); ++r) map_[rows_[rows_begin_[s] + r]] = r;
  descendant_ = head_[s];
}

// Brings what the descendant has for it into the supernode; returns the multiplications.
template <int kBlock>
double BlockCholesky<kBlock>::UpdateFrom(int descendant) {
  const int first_row = next_row_[descendant];
  int last = first_row;
  while (last < Rows(descendant) &&
         rows_[rows_begin_[descendant] + last] < super_begin_[super_ + 1]) {
    ++last;
  }
  Update(super_, descendant, first_row, last - first_row);
  next_row_[descendant] = last;
  Queue(descendant);
  return static_cast<double>(kBlockSize * kBlock) * (Rows(descendant) - first_row) *
         (last - first_row) * Width(descendant);
}

template <int kBlock>
typename BlockCholesky<kBlock>::Progress BlockCholesky<kBlock>::GoOn(double multiplications) {
  const int num = static_cast<int>(super_begin_.size()) - 1;
  while (super_ < num) {
    const int s = super_, num_rows = Rows(s);
    while (descendant_ >= 0) {
      if (multiplications <= 0) return Progress::kUnderWay;
      const int descendant = std::exchange(descendant_, next_[descendant_]);
      multiplications -= UpdateFrom(descendant);
    }
    if (!FactorPanel(num_rows * kBlock, Width(s) * kBlock, &factor_[panel_begin_[s]], panel_ld_[s],
                     &min_pivot_[static_cast<std::size_t>(super_begin_[s]) * kBlock])) {
      return Progress::kFailed;
    }
    multiplications -= static_cast<double>(kBlockSize * kBlock) * num_rows * Width(s) * Width(s);
    next_row_[s] = Width(s);
    Queue(s);
    if (++super_ < num) BeginPanel(super_);
  }
  return Progress::kDone;
}

template <int kBlock>
void BlockCholesky<kBlock>::Solve(double* x) const {
  const int num = static_cast<int>(super_begin_.size()) - 1;
  work_.resize(static_cast<std::size_t>(n_) * kBlock);
  const auto at = [&](int position) { return &work_[static_cast<std::size_t>(position) * kBlock]; };
  for (int i = 0; i < n_; ++i) {
    std::copy_n(x + static_cast<std::ptrdiff_t>(i) * kBlock, kBlock, at(position_[i]));
  }
  // The numbers of a supernode's rows, side by side. Kernels run over what is behind them.
  const auto gather = [&](int s) {
    rows_work_.resize(static_cast<std::size_t>(Rows(s)) * kBlock);
    rows_work_.resize(rows_work_.size() + kPadding, 0.);
    for (int r = 0; r < Rows(s); ++r) {
      std::copy_n(at(rows_[rows_begin_[s] + r]), kBlock, &rows_work_[r * kBlock]);
    }
  };
  for (int s = 0; s < num; ++s) {
    gather(s);
    ForwardPanel(Rows(s) * kBlock, Width(s) * kBlock, &factor_[panel_begin_[s]], panel_ld_[s],
                 rows_work_.data());
    for (int r = 0; r < Rows(s); ++r) {
      std::copy_n(&rows_work_[r * kBlock], kBlock, at(rows_[rows_begin_[s] + r]));
    }
  }
  for (int s = num - 1; s >= 0; --s) {
    gather(s);
    BackwardPanel(Rows(s) * kBlock, Width(s) * kBlock, &factor_[panel_begin_[s]], panel_ld_[s],
                  rows_work_.data());
    std::copy_n(rows_work_.data(), Width(s) * kBlock, at(super_begin_[s]));
  }
  for (int i = 0; i < n_; ++i) {
    std::copy_n(at(position_[i]), kBlock, x + static_cast<std::ptrdiff_t>(i) * kBlock);
  }
}

template class BlockCholesky<3>;
template class BlockCholesky<4>;
template class BlockCholesky<6>;

}  // namespace hpgo
