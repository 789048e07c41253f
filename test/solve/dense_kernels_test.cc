// Built twice: with the kernels of the library, and with those for the baseline of x86-64, which a
// processor with AVX2 never runs otherwise.
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "gtest/gtest.h"
#ifdef HPGO_TEST_BASELINE
#undef __x86_64__
#include "hpgo/solve/dense_kernels.cc"
#else
#include "hpgo/solve/dense_kernels.h"
#endif

namespace hpgo {
namespace {

// A column-major matrix with the padding that the kernels ask for: rows of zeros up to the leading
// dimension, and a guard of other numbers after the spare ones at the end.
class Panel {
 public:
  Panel(int rows, int cols, int extra_ld)
      : rows_(rows),
        cols_(cols),
        ld_((rows + kPadding - 1 + kPadding - 1) / kPadding * kPadding + extra_ld),
        data_(static_cast<std::size_t>(ld_) * cols + kPadding + kGuard, 0.) {
    for (int k = 0; k < kGuard; ++k) data_[data_.size() - 1 - k] = 1000 + k;
  }

  int ld() const { return ld_; }
  double* data() { return data_.data(); }
  auto matrix() {
    return Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>>(data_.data(), rows_, cols_,
                                                                Eigen::OuterStride<>(ld_));
  }

  testing::AssertionResult PaddingIsIntact() const {
    for (int c = 0; c < cols_; ++c) {
      for (int r = rows_; r < ld_; ++r) {
        if (data_[static_cast<std::size_t>(c) * ld_ + r] == 0) continue;
        return testing::AssertionFailure() << "row " << r << " of column " << c << " is not zero";
      }
    }
    for (int k = 0; k < kGuard; ++k) {
      if (data_[data_.size() - 1 - k] == 1000 + k) continue;
      return testing::AssertionFailure() << "the buffer was written behind its end";
    }
    return testing::AssertionSuccess();
  }

 private:
  static constexpr int kGuard = 16;
  int rows_, cols_, ld_;
  std::vector<double> data_;
};

class DenseKernelsTest : public testing::Test {
 protected:
  void Fill(Panel* panel) {
    std::uniform_real_distribution<double> uniform(-1, 1);
    auto m = panel->matrix();
    for (int c = 0; c < m.cols(); ++c) {
      for (int r = 0; r < m.rows(); ++r) m(r, c) = uniform(rng_);
    }
  }

  void CheckProduct(int m, int n, int k, int extra_ld) {
    SCOPED_TRACE(testing::Message() << "m " << m << ", n " << n << ", k " << k);
    Panel A(m, k, extra_ld), B(n, k, 0), C(m, n, 2 * extra_ld);
    Fill(&A);
    Fill(&B);
    Fill(&C);
    const Eigen::MatrixXd expected = C.matrix() - A.matrix() * B.matrix().transpose();
    SubtractProduct(m, n, k, A.data(), A.ld(), B.data(), B.ld(), C.data(), C.ld());
    EXPECT_LE((C.matrix() - expected).cwiseAbs().maxCoeff(), 1e-13 * (k + 1));
    EXPECT_TRUE(C.PaddingIsIntact());
  }

  // The leading part is made positive definite.
  Panel MakePanel(int rows, int cols, int extra_ld) {
    Panel panel(rows, cols, extra_ld);
    Fill(&panel);
    auto m = panel.matrix();
    const Eigen::MatrixXd top = m.topRows(cols);
    m.topRows(cols) = top * top.transpose() + Eigen::MatrixXd::Identity(cols, cols);
    return panel;
  }

  void CheckFactor(int rows, int cols, int extra_ld) {
    SCOPED_TRACE(testing::Message() << "rows " << rows << ", cols " << cols);
    Panel panel = MakePanel(rows, cols, extra_ld);
    auto m = panel.matrix();
    const Eigen::MatrixXd top = m.topRows(cols), below = m.bottomRows(rows - cols);
    m.topRows(cols).triangularView<Eigen::StrictlyUpper>().setConstant(7);  // not to be read
    const std::vector<double> min_pivot(cols, 1e-14);
    ASSERT_TRUE(FactorPanel(rows, cols, panel.data(), panel.ld(), min_pivot.data()));
    const Eigen::LLT<Eigen::MatrixXd> llt(top);
    const Eigen::MatrixXd L = m.topRows(cols).triangularView<Eigen::Lower>();
    EXPECT_LE((L - llt.matrixL().toDenseMatrix()).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LE((L * m.bottomRows(rows - cols).transpose() - below.transpose()).norm(), 1e-10 * rows);
    EXPECT_TRUE(panel.PaddingIsIntact());
  }

  void CheckSolve(int rows, int cols) {
    SCOPED_TRACE(testing::Message() << "rows " << rows << ", cols " << cols);
    Panel panel = MakePanel(rows, cols, 0);
    const std::vector<double> min_pivot(cols, 1e-14);
    ASSERT_TRUE(FactorPanel(rows, cols, panel.data(), panel.ld(), min_pivot.data()));
    panel.matrix().topRows(cols).triangularView<Eigen::StrictlyUpper>().setConstant(7);
    const Eigen::MatrixXd L = panel.matrix().topRows(cols).triangularView<Eigen::Lower>();
    const Eigen::MatrixXd below = panel.matrix().bottomRows(rows - cols);
    Panel x(rows, 1, 0);
    Fill(&x);
    const Eigen::VectorXd right = x.matrix();
    Eigen::VectorXd expected = right;
    expected.head(cols) = L.triangularView<Eigen::Lower>().solve(right.head(cols));
    expected.tail(rows - cols) -= below * expected.head(cols);
    ForwardPanel(rows, cols, panel.data(), panel.ld(), x.data());
    EXPECT_LE((x.matrix() - expected).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_TRUE(x.PaddingIsIntact());
    x.matrix() = right;
    expected = right;
    expected.head(cols) = L.transpose().triangularView<Eigen::Upper>().solve(
        right.head(cols) - below.transpose() * right.tail(rows - cols));
    BackwardPanel(rows, cols, panel.data(), panel.ld(), x.data());
    EXPECT_LE((x.matrix() - expected).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_TRUE(x.PaddingIsIntact());
  }

  std::mt19937 rng_{3};
};

TEST_F(DenseKernelsTest, SolvesWithPanelsOfEveryShape) {
  for (const int cols : {1, 2, 3, 4, 6, 8, 9, 12, 16, 24}) {
    for (int rows = cols; rows < cols + 20; ++rows) CheckSolve(rows, cols);
  }
}

TEST_F(DenseKernelsTest, SubtractsProductsOfEveryShape) {
  for (int m = 1; m <= 40; ++m) {
    for (const int n : {1, 2, 3, 4, 6, 8, 9, 12, 21}) {
      for (const int k : {0, 1, 3, 6, 13}) CheckProduct(m, n, k, m % 3 == 0 ? 8 : 0);
    }
  }
}

TEST_F(DenseKernelsTest, SubtractsLargeProducts) {
  std::uniform_int_distribution<int> size(1, 120), thirds(1, 40);
  for (int trial = 0; trial < 100; ++trial) {
    CheckProduct(size(rng_), 3 * thirds(rng_), 3 * thirds(rng_), 4 * (trial % 3));
  }
  CheckProduct(120, 120, 120, 0);
}

// As the factorization does in place: the columns of a panel from those before them.
TEST_F(DenseKernelsTest, SubtractsFromFurtherColumnsOfTheSamePanel) {
  for (int rows = 12; rows < 60; rows += 3) {
    Panel panel(rows, 9, 0);
    Fill(&panel);
    auto m = panel.matrix();
    Eigen::MatrixXd expected = m;
    expected.block(6, 6, rows - 6, 3) -=
        m.block(6, 0, rows - 6, 6) * m.block(6, 0, 3, 6).transpose();
    SubtractProduct(rows - 6, 3, 6, panel.data() + 6, panel.ld(), panel.data() + 6, panel.ld(),
                    panel.data() + 6 * panel.ld() + 6, panel.ld());
    EXPECT_LE((m - expected).cwiseAbs().maxCoeff(), 1e-14) << rows;
    EXPECT_TRUE(panel.PaddingIsIntact());
  }
}

TEST_F(DenseKernelsTest, FactorsPanelsOfEveryShape) {
  for (int cols = 1; cols <= 24; ++cols) {
    for (int below = 0; below <= 30; ++below) CheckFactor(cols + below, cols, 4 * (below % 2));
  }
}

TEST_F(DenseKernelsTest, FactorsLargePanels) {
  std::uniform_int_distribution<int> thirds(1, 40);
  for (int trial = 0; trial < 40; ++trial) {
    const int cols = 3 * thirds(rng_);
    CheckFactor(cols + 3 * (thirds(rng_) - 1), cols, 0);
  }
  CheckFactor(240, 120, 0);
}

TEST_F(DenseKernelsTest, StopsAtAPivotThatIsTooSmall) {
  for (int bad = 0; bad < 14; ++bad) {
    for (const double pivot : {1.5, 0.0, -1.0, std::nan("")}) {
      Panel panel(15, 14, 0);
      panel.matrix().setZero();
      panel.matrix().topRows(14).setIdentity();
      panel.matrix()(bad, bad) = pivot;
      std::vector<double> min_pivot(14, 0.5);
      min_pivot[bad] = 2;
      EXPECT_FALSE(FactorPanel(15, 14, panel.data(), panel.ld(), min_pivot.data())) << bad;
      min_pivot[bad] = 0.5;
      EXPECT_EQ(FactorPanel(15, 14, panel.data(), panel.ld(), min_pivot.data()), pivot == 1.5);
    }
  }
}

TEST_F(DenseKernelsTest, StopsAtAnIndefiniteMatrix) {
  for (int cols = 1; cols <= 30; ++cols) {
    Panel panel = MakePanel(cols + 6, cols, 0);
    panel.matrix().topRows(cols).diagonal().array() -=
        2 + Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(panel.matrix().topRows(cols))
                .eigenvalues()(0);
    const std::vector<double> min_pivot(cols, 0.);
    EXPECT_FALSE(FactorPanel(cols + 6, cols, panel.data(), panel.ld(), min_pivot.data())) << cols;
  }
}

}  // namespace
}  // namespace hpgo
