#include "hpgo/solve/dense_kernels.h"

#include <cmath>

// The kernels are compiled twice, for the baseline of the target and for AVX2 with FMA, from the
// same source: the vector type is as wide as an AVX2 register and is split in two on the baseline.
#if defined(__x86_64__)
#define HPGO_AVX2 __attribute__((target("avx2,fma")))
#endif
#define HPGO_INLINE inline __attribute__((always_inline))

namespace hpgo {
namespace {

typedef double Vector4 __attribute__((vector_size(32), aligned(8), may_alias));

// Rows of a tile in vectors, and its columns: nine accumulators, three rows of A and one broadcast
// fit the sixteen registers.
constexpr int kTileColumns = 3;

template <int kVectors, int kColumns>
HPGO_INLINE void Tile(int k, const double* A, int lda, const double* B, int ldb, double* C,
                      int ldc) {
  Vector4 sum[kColumns][kVectors];
  for (int c = 0; c < kColumns; ++c) {
    for (int v = 0; v < kVectors; ++v) sum[c][v] = Vector4{0, 0, 0, 0};
  }
  for (int p = 0; p < k; ++p, A += lda, B += ldb) {
    Vector4 a[kVectors];
    for (int v = 0; v < kVectors; ++v) a[v] = *reinterpret_cast<const Vector4*>(A + 4 * v);
    for (int c = 0; c < kColumns; ++c) {
      const double b = B[c];
      for (int v = 0; v < kVectors; ++v) sum[c][v] += a[v] * b;
    }
  }
  for (int c = 0; c < kColumns; ++c) {
    for (int v = 0; v < kVectors; ++v) {
      *reinterpret_cast<Vector4*>(C + c * ldc + 4 * v) -= sum[c][v];
    }
  }
}

// A product of kColumns columns.
template <int kColumns>
HPGO_INLINE void SubtractColumns(int m, int k, const double* A, int lda, const double* B, int ldb,
                                 double* C, int ldc) {
  int i = 0;
  for (; m - i > 8; i += 12) Tile<3, kColumns>(k, A + i, lda, B, ldb, C + i, ldc);
  if (m - i > 4) {
    Tile<2, kColumns>(k, A + i, lda, B, ldb, C + i, ldc);
  } else if (m - i > 0) {
    Tile<1, kColumns>(k, A + i, lda, B, ldb, C + i, ldc);
  }
}

HPGO_INLINE void SubtractProductImpl(int m, int n, int k, const double* A, int lda, const double* B,
                                     int ldb, double* C, int ldc) {
  const auto column = [&](int j) { return C + static_cast<long>(j) * ldc; };
  int j = 0;
  for (; n - j >= kTileColumns; j += kTileColumns) {
    SubtractColumns<kTileColumns>(m, k, A, lda, B + j, ldb, column(j), ldc);
  }
  if (n - j == 2) {
    SubtractColumns<2>(m, k, A, lda, B + j, ldb, column(j), ldc);
  } else if (n - j == 1) {
    SubtractColumns<1>(m, k, A, lda, B + j, ldb, column(j), ldc);
  }
}

HPGO_INLINE bool FactorPanelImpl(int rows, int cols, double* panel, int ld,
                                 const double* min_pivot) {
  int j = 0;
  for (; cols - j >= 3; j += 3) {
    double* c0 = panel + static_cast<long>(j) * ld;
    double* c1 = c0 + ld;
    double* c2 = c1 + ld;
    SubtractColumns<3>(rows - j, j, panel + j, ld, panel + j, ld, c0 + j, ld);
    const double d0 = c0[j];
    if (!(d0 > min_pivot[j])) return false;
    const double i0 = 1 / std::sqrt(d0);
    const double l10 = c0[j + 1] * i0, l20 = c0[j + 2] * i0;
    const double d1 = c1[j + 1] - l10 * l10;
    if (!(d1 > min_pivot[j + 1])) return false;
    const double i1 = 1 / std::sqrt(d1);
    const double l21 = (c1[j + 2] - l20 * l10) * i1;
    const double d2 = c2[j + 2] - l20 * l20 - l21 * l21;
    if (!(d2 > min_pivot[j + 2])) return false;
    const double i2 = 1 / std::sqrt(d2);
    for (int r = j; r < rows; ++r) {
      const double x0 = c0[r] * i0;
      const double x1 = (c1[r] - x0 * l10) * i1;
      c0[r] = x0;
      c1[r] = x1;
      c2[r] = (c2[r] - x0 * l20 - x1 * l21) * i2;
    }
    c1[j] = c2[j] = c2[j + 1] = 0;
  }
  for (; j < cols; ++j) {
    double* c0 = panel + static_cast<long>(j) * ld;
    SubtractColumns<1>(rows - j, j, panel + j, ld, panel + j, ld, c0 + j, ld);
    if (!(c0[j] > min_pivot[j])) return false;
    const double i0 = 1 / std::sqrt(c0[j]);
    for (int r = j; r < rows; ++r) c0[r] *= i0;
  }
  return true;
}

HPGO_INLINE void ForwardPanelImpl(int rows, int cols, const double* panel, int ld, double* x) {
  int j = 0;
  for (; cols - j >= 3; j += 3) {
    const double* c0 = panel + static_cast<long>(j) * ld;
    const double* c1 = c0 + ld;
    const double* c2 = c1 + ld;
    const double x0 = x[j] /= c0[j];
    const double x1 = x[j + 1] = (x[j + 1] - c0[j + 1] * x0) / c1[j + 1];
    const double x2 = x[j + 2] = (x[j + 2] - c0[j + 2] * x0 - c1[j + 2] * x1) / c2[j + 2];
    for (int r = j + 3; r < rows; r += 4) {
      *reinterpret_cast<Vector4*>(x + r) -= *reinterpret_cast<const Vector4*>(c0 + r) * x0 +
                                            *reinterpret_cast<const Vector4*>(c1 + r) * x1 +
                                            *reinterpret_cast<const Vector4*>(c2 + r) * x2;
    }
  }
  for (; j < cols; ++j) {
    const double* c0 = panel + static_cast<long>(j) * ld;
    const double x0 = x[j] /= c0[j];
    for (int r = j + 1; r < rows; r += 4) {
      *reinterpret_cast<Vector4*>(x + r) -= *reinterpret_cast<const Vector4*>(c0 + r) * x0;
    }
  }
}

HPGO_INLINE double Sum(const Vector4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

HPGO_INLINE void BackwardPanelImpl(int rows, int cols, const double* panel, int ld, double* x) {
  int end = cols;
  for (; end % 3 != 0; --end) {
    const int j = end - 1;
    const double* c0 = panel + static_cast<long>(j) * ld;
    Vector4 s0 = {0, 0, 0, 0};
    for (int r = j + 1; r < rows; r += 4) {
      s0 += *reinterpret_cast<const Vector4*>(c0 + r) * *reinterpret_cast<const Vector4*>(x + r);
    }
    x[j] = (x[j] - Sum(s0)) / c0[j];
  }
  for (int j = end - 3; j >= 0; j -= 3) {
    const double* c0 = panel + static_cast<long>(j) * ld;
    const double* c1 = c0 + ld;
    const double* c2 = c1 + ld;
    Vector4 s0 = {0, 0, 0, 0}, s1 = s0, s2 = s0;
    for (int r = j + 3; r < rows; r += 4) {
      const Vector4 below = *reinterpret_cast<const Vector4*>(x + r);
      s0 += *reinterpret_cast<const Vector4*>(c0 + r) * below;
      s1 += *reinterpret_cast<const Vector4*>(c1 + r) * below;
      s2 += *reinterpret_cast<const Vector4*>(c2 + r) * below;
    }
    const double x2 = x[j + 2] = (x[j + 2] - Sum(s2)) / c2[j + 2];
    const double x1 = x[j + 1] = (x[j + 1] - Sum(s1) - c1[j + 2] * x2) / c1[j + 1];
    x[j] = (x[j] - Sum(s0) - c0[j + 1] * x1 - c0[j + 2] * x2) / c0[j];
  }
}

#if defined(__x86_64__)
HPGO_AVX2 void ForwardPanelAvx2(int rows, int cols, const double* panel, int ld, double* x) {
  ForwardPanelImpl(rows, cols, panel, ld, x);
}
HPGO_AVX2 void BackwardPanelAvx2(int rows, int cols, const double* panel, int ld, double* x) {
  BackwardPanelImpl(rows, cols, panel, ld, x);
}
HPGO_AVX2 void SubtractProductAvx2(int m, int n, int k, const double* A, int lda, const double* B,
                                   int ldb, double* C, int ldc) {
  SubtractProductImpl(m, n, k, A, lda, B, ldb, C, ldc);
}
HPGO_AVX2 bool FactorPanelAvx2(int rows, int cols, double* panel, int ld, const double* min_pivot) {
  return FactorPanelImpl(rows, cols, panel, ld, min_pivot);
}
bool HasAvx2() {
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  return has;
}
#endif

}  // namespace

void SubtractProduct(int m, int n, int k, const double* A, int lda, const double* B, int ldb,
                     double* C, int ldc) {
#if defined(__x86_64__)
  if (HasAvx2()) return SubtractProductAvx2(m, n, k, A, lda, B, ldb, C, ldc);
#endif
  SubtractProductImpl(m, n, k, A, lda, B, ldb, C, ldc);
}

bool FactorPanel(int rows, int cols, double* panel, int ld, const double* min_pivot) {
#if defined(__x86_64__)
  if (HasAvx2()) return FactorPanelAvx2(rows, cols, panel, ld, min_pivot);
#endif
  return FactorPanelImpl(rows, cols, panel, ld, min_pivot);
}

void ForwardPanel(int rows, int cols, const double* panel, int ld, double* x) {
#if defined(__x86_64__)
  if (HasAvx2()) return ForwardPanelAvx2(rows, cols, panel, ld, x);
#endif
  ForwardPanelImpl(rows, cols, panel, ld, x);
}

void BackwardPanel(int rows, int cols, const double* panel, int ld, double* x) {
#if defined(__x86_64__)
  if (HasAvx2()) return BackwardPanelAvx2(rows, cols, panel, ld, x);
#endif
  BackwardPanelImpl(rows, cols, panel, ld, x);
}

}  // namespace hpgo
