// The dense kernels of the block Cholesky factorization, on column-major panels.
//
// Panels are padded: a kernel may read and write up to kPadding - 1 rows below those it is asked
// for, so leading dimensions are multiples of kPadding, and buffers end with kPadding spare
// numbers. Uses AVX2 and FMA where the processor has them.
#pragma once

namespace hpgo {

inline constexpr int kPadding = 4;
inline constexpr int RoundUp(int n) { return (n + kPadding - 1) / kPadding * kPadding; }

// C -= A B' with A m x k, B n x k, C m x n. This and all below go by three columns at a time, and
// are slower in those left over.
void SubtractProduct(int m, int n, int k, const double* A, int lda, const double* B, int ldb,
                     double* C, int ldc);

// Factors the leading `cols` rows of the panel in place, L L' of its lower triangle, and solves for
// the rows below. A pivot that is not above min_pivot[column] stops it and returns false.
bool FactorPanel(int rows, int cols, double* panel, int ld, const double* min_pivot);

// With a factored panel: solves L y = x for the leading `cols` of x, in place, and subtracts what
// that contributes to the rows below.
void ForwardPanel(int rows, int cols, const double* panel, int ld, double* x);

// With a factored panel: solves L' y = x for the leading `cols` of x, in place, the rows below
// given.
void BackwardPanel(int rows, int cols, const double* panel, int ld, double* x);

}  // namespace hpgo
