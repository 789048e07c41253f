#include "hpgo/ceres/free_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "Eigen/Core"

namespace hpgo {
namespace {

template <int Rows, int Cols>
using RowMajor = Eigen::Matrix<double, Rows, Cols, Cols == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

// J is m x Size and P Size x Tangent, row-major; see ToLocal.
template <int Size, int Tangent>
void MultiplyFixed(int m, const double* J, const double* P, double* out) {
  const Eigen::Map<const RowMajor<Size, Tangent>> p(P);
  for (int r = 0; r < m; ++r) {
    const Eigen::Matrix<double, 1, Tangent> row =
        Eigen::Map<const Eigen::Matrix<double, 1, Size>>(J + r * Size) * p;
    for (int c = 0; c < Tangent; ++c) out[c * m + r] = row(c);
  }
}

void MultiplyAny(int m, int size, int tangent, const double* J, const double* P, double* out) {
  for (int r = 0; r < m; ++r) {
    for (int c = 0; c < tangent; ++c) {
      double sum = 0;
      for (int k = 0; k < size; ++k) sum += J[r * size + k] * P[k * tangent + c];
      out[c * m + r] = sum;
    }
  }
}

}  // namespace

FreeBlocks::FreeBlocks(const ProblemView& problem, const PoseBlocks& poses, int stride)
    : problem_(problem),
      poses_(poses),
      place_of_(problem.blocks().size(), -1),
      number_of_(poses.num_poses(), -1) {
  int jacobian_at = 0;
  for (std::size_t b = 0; b < problem_.blocks().size(); ++b) {
    const BlockView& view = problem_.blocks()[b];
    if (view.constant || !view.used) continue;
    int& number = number_of_[poses_.pose_of[b]];
    if (number < 0) number = num_poses_++;
    FreeBlock block;
    block.size = view.size;
    block.tangent = view.tangent;
    block.offset = view.offset;
    block.step_at = number * stride + poses_.column_of[b];
    block.manifold = view.manifold;
    if (view.manifold != nullptr) {
      block.jacobian_at = jacobian_at;
      jacobian_at += view.size * view.tangent;
    }
    place_of_[b] = num_blocks();
    blocks_.push_back(block);
  }
  plus_jacobians_.resize(jacobian_at);
}

int FreeBlocks::Sum(int FreeBlock::*field) const {
  int sum = 0;
  for (const FreeBlock& block : blocks_) sum += block.*field;
  return sum;
}

void FreeBlocks::UpdatePlusJacobians(const std::vector<double>& values) {
  for (const FreeBlock& block : blocks_) {
    if (block.manifold == nullptr) continue;
    double* P = &plus_jacobians_[block.jacobian_at];
    if (!block.manifold->PlusJacobian(&values[block.offset], P)) {
      std::fill_n(P, block.size * block.tangent, std::numeric_limits<double>::quiet_NaN());
    }
  }
}

void FreeBlocks::ToLocal(int m, int place, const double* J, double* out) const {
  const FreeBlock& block = blocks_[place];
  if (block.jacobian_at < 0) {
    for (int r = 0; r < m; ++r) {
      for (int c = 0; c < block.size; ++c) out[c * m + r] = J[r * block.size + c];
    }
    return;
  }
  const double* P = &plus_jacobians_[block.jacobian_at];
  if (block.size == 7 && block.tangent == 6) {
    MultiplyFixed<7, 6>(m, J, P, out);
  } else if (block.size == 4 && block.tangent == 3) {
    MultiplyFixed<4, 3>(m, J, P, out);
  } else if (block.size == 3 && block.tangent == 3) {
    MultiplyFixed<3, 3>(m, J, P, out);
  } else {
    MultiplyAny(m, block.size, block.tangent, J, P, out);
  }
}

bool FreeBlocks::Move(const std::vector<double>& values, const std::vector<double>& step,
                      double part, std::vector<double>* moved, Norms* norms) {
  *moved = values;
  double step_sum = 0, value_sum = 0;
  for (const FreeBlock& block : blocks_) {
    const double* x = &values[block.offset];
    double* y = &(*moved)[block.offset];
    delta_.resize(block.tangent);
    for (int c = 0; c < block.tangent; ++c) delta_[c] = part * step[block.step_at + c];
    if (block.manifold == nullptr) {
      for (int c = 0; c < block.size; ++c) y[c] = x[c] + delta_[c];
    } else if (!block.manifold->Plus(x, delta_.data(), y)) {
      return false;
    }
    for (int c = 0; c < block.size; ++c) {
      step_sum += (y[c] - x[c]) * (y[c] - x[c]);
      value_sum += x[c] * x[c];
    }
  }
  norms->step = std::sqrt(step_sum);
  norms->value = std::sqrt(value_sum);
  return true;
}

bool FreeBlocks::Measure(const std::vector<double>& values, const std::vector<double>& gradient,
                         GradientNorms* norms) {
  double sum = 0;
  norms->max_norm = 0;
  for (const FreeBlock& block : blocks_) {
    const double* x = &values[block.offset];
    const double* g = &gradient[block.step_at];
    moved_.resize(block.size);
    delta_.resize(block.tangent);
    for (int c = 0; c < block.tangent; ++c) delta_[c] = -g[c];
    if (block.manifold == nullptr) {
      for (int c = 0; c < block.size; ++c) moved_[c] = x[c] - g[c];
    } else if (!block.manifold->Plus(x, delta_.data(), moved_.data())) {
      return false;
    }
    for (int c = 0; c < block.size; ++c) {
      const double d = moved_[c] - x[c];
      sum += d * d;
      norms->max_norm = std::max(norms->max_norm, std::abs(d));
    }
  }
  norms->norm = std::sqrt(sum);
  return std::isfinite(sum);
}

void FreeBlocks::Write(const std::vector<double>& values) const {
  for (std::size_t b = 0; b < problem_.blocks().size(); ++b) {
    const BlockView& block = problem_.blocks()[b];
    if (place_of_[b] >= 0) std::copy_n(&values[block.offset], block.size, block.values);
  }
}

}  // namespace hpgo
