// The upper triangle of a symmetric matrix, row-major: the order of information matrices in g2o
// files, at 21 numbers instead of 36.
#pragma once

#include "Eigen/Core"

namespace ceres_costs {

template <int N>
class PackedSymmetric {
 public:
  static constexpr int kSize = N * (N + 1) / 2;
  using Matrix = Eigen::Matrix<double, N, N>;

  PackedSymmetric() : values_{} {}
  // Takes the upper triangle of `m`.
  explicit PackedSymmetric(const Matrix& m) {
    for (int r = 0, k = 0; r < N; ++r) {
      for (int c = r; c < N; ++c) values_[k++] = m(r, c);
    }
  }

  Matrix Dense() const {
    Matrix m;
    for (int r = 0, k = 0; r < N; ++r) {
      for (int c = r; c < N; ++c, ++k) m(r, c) = m(c, r) = values_[k];
    }
    return m;
  }
  const double* data() const { return values_; }
  double* data() { return values_; }
  // For archives.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.values_);
  }

 private:
  double values_[kSize];
};

}  // namespace ceres_costs
