#include "hpgo/solve/block_cholesky.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Eigenvalues"
#include "block_patterns.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

template <int kBlock>
struct Traits {
  static constexpr int kSize = kBlock;
};

template <typename T>
class BlockCholeskyTest : public testing::Test {
 protected:
  static constexpr int B = T::kSize;
  using Block = Eigen::Matrix<double, B, B>;

  Block RandomBlock() {
    std::uniform_real_distribution<double> uniform(-1, 1);
    Block block;
    for (int k = 0; k < block.size(); ++k) block.data()[k] = uniform(rng_);
    return block;
  }

  // Analyzes, fills with random values and returns the dense matrix. As a sum of one square a pair
  // and a node it is positive definite, with entries of very different size.
  Eigen::MatrixXd Fill(int n, const Pairs& pairs, BlockCholesky<B>* cholesky) {
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n * B, n * B);
    cholesky->Analyze(n, pairs);
    std::uniform_real_distribution<double> exponent(-2, 2);
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const auto [i, j] = pairs[p];
      const double scale = std::pow(10, exponent(rng_));
      const Block P = RandomBlock(), Q = RandomBlock();
      const Block off = scale * P.transpose() * Q;
      dense.template block<B, B>(i * B, i * B) += scale * P.transpose() * P;
      dense.template block<B, B>(j * B, j * B) += scale * Q.transpose() * Q;
      dense.template block<B, B>(i * B, j * B) = off;
      dense.template block<B, B>(j * B, i * B) = off.transpose();
      Eigen::Map<Block>(cholesky->OffDiagonal(static_cast<int>(p))) = off;
    }
    for (int i = 0; i < n; ++i) {
      const Block A = RandomBlock();
      auto block = dense.template block<B, B>(i * B, i * B);
      block += A.transpose() * A + 0.1 * Block::Identity();
      Eigen::Map<Block>(cholesky->Diagonal(i)) = block;
    }
    return dense;
  }

  // Solves with random right-hand sides.
  void CheckSolution(const Eigen::MatrixXd& dense, const BlockCholesky<B>& cholesky) {
    for (int trial = 0; trial < 2; ++trial) {
      const Eigen::VectorXd b = Eigen::VectorXd::Random(dense.rows());
      Eigen::VectorXd x = b;
      cholesky.Solve(x.data());
      const Eigen::VectorXd expected = dense.llt().solve(b);
      EXPECT_LE((x - expected).norm(), 1e-8 * (1 + expected.norm()));
      EXPECT_LE((dense * x - b).norm(), 1e-10 * (1 + dense.norm() * x.norm()));
    }
  }

  void Check(int n, const Pairs& pairs) {
    SCOPED_TRACE(testing::Message() << n << " nodes, " << pairs.size() << " pairs");
    const Eigen::MatrixXd dense = Fill(n, pairs, &cholesky_);
    ASSERT_TRUE(cholesky_.Factor(0));
    CheckSolution(dense, cholesky_);
    for (const double lambda : {1e-6, 0.3, 100.0}) {
      Eigen::MatrixXd damped = dense;
      damped.diagonal() *= 1 + lambda;
      ASSERT_TRUE(cholesky_.Factor(lambda));
      CheckSolution(damped, cholesky_);
    }
    ASSERT_TRUE(cholesky_.Factor(0));  // the values stayed
    CheckSolution(dense, cholesky_);
  }

  std::mt19937 rng_{5};
  BlockCholesky<B> cholesky_;  // one object for all patterns of a test
};

using Sizes = testing::Types<Traits<3>, Traits<4>, Traits<6>>;
TYPED_TEST_SUITE(BlockCholeskyTest, Sizes);

TYPED_TEST(BlockCholeskyTest, TakesAnEmptyMatrix) {
  this->cholesky_.Analyze(0, {});
  EXPECT_TRUE(this->cholesky_.Factor(0));
  this->cholesky_.Solve(nullptr);
  EXPECT_EQ(this->cholesky_.factor_size(), 0);
}

TYPED_TEST(BlockCholeskyTest, SolvesASingleNode) { this->Check(1, {}); }

TYPED_TEST(BlockCholeskyTest, SolvesChains) {
  for (const int n : {2, 3, 10, 60}) this->Check(n, Chain(n));
}

TYPED_TEST(BlockCholeskyTest, SolvesStars) {
  for (const int centre : {0, 7, 29}) this->Check(30, Star(30, centre));
}

TYPED_TEST(BlockCholeskyTest, SolvesDenseMatrices) {
  for (const int n : {2, 3, 8, 25}) this->Check(n, Complete(n));
}

TYPED_TEST(BlockCholeskyTest, SolvesGrids) {
  for (const int side : {3, 6, 9}) this->Check(side * side, Grid(side, side));
}

TYPED_TEST(BlockCholeskyTest, SolvesDisconnectedParts) {
  this->Check(20, {});
  this->Check(12, {{3, 4}, {4, 5}, {9, 8}, {0, 11}});
  Pairs two = Chain(10);
  for (const auto& [i, j] : Complete(8)) two.emplace_back(i + 10, j + 10);
  this->Check(20, two);
}

TYPED_TEST(BlockCholeskyTest, SolvesRandomPatternsWithOneObject) {
  std::uniform_int_distribution<int> size(1, 50);
  std::uniform_real_distribution<double> density(0, 4);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = size(this->rng_);
    this->Check(n, RandomPairs(n, static_cast<int>(density(this->rng_) * n), &this->rng_));
    if (testing::Test::HasFailure()) return;
  }
}

TYPED_TEST(BlockCholeskyTest, AnalyzeAndSetZeroForgetTheValues) {
  constexpr int kBlock = TypeParam::kSize;
  const Pairs pairs = Grid(4, 4);
  this->Fill(16, pairs, &this->cholesky_);
  this->cholesky_.SetZero();
  EXPECT_FALSE(this->cholesky_.Factor(0));
  this->Fill(16, pairs, &this->cholesky_);
  this->cholesky_.Analyze(16, pairs);
  for (int i = 0; i < 16; ++i) {
    for (int k = 0; k < kBlock; ++k) this->cholesky_.Diagonal(i)[k * (kBlock + 1)] = i + 1;
  }
  ASSERT_TRUE(this->cholesky_.Factor(0));
  std::vector<double> x(16 * kBlock, 1.);
  this->cholesky_.Solve(x.data());
  for (int k = 0; k < 16 * kBlock; ++k) EXPECT_DOUBLE_EQ(x[k], 1. / (k / kBlock + 1)) << k;
}

TYPED_TEST(BlockCholeskyTest, TheSameMatrixGivesTheSameBits) {
  const Pairs pairs = RandomPairs(40, 120, &this->rng_);
  BlockCholesky<TypeParam::kSize> other;
  this->Check(25, Complete(25));  // leaves its workspace behind
  this->rng_.seed(8);
  this->Fill(40, pairs, &this->cholesky_);
  this->rng_.seed(8);
  const Eigen::MatrixXd dense = this->Fill(40, pairs, &other);
  ASSERT_TRUE(this->cholesky_.Factor(0));
  ASSERT_TRUE(other.Factor(0));
  Eigen::VectorXd x = Eigen::VectorXd::Ones(dense.rows()), y = x;
  this->cholesky_.Solve(x.data());
  other.Solve(y.data());
  EXPECT_EQ(x, y);
  EXPECT_EQ(this->cholesky_.factor_size(), other.factor_size());
}

TYPED_TEST(BlockCholeskyTest, SharesGiveTheSameBits) {
  using Cholesky = BlockCholesky<TestFixture::B>;
  const Pairs pairs = Grid(9, 7);
  Cholesky whole, shared;
  const Eigen::MatrixXd dense = this->Fill(63, pairs, &whole);
  shared.Analyze(63, pairs);
  for (int i = 0; i < 63; ++i) {
    std::copy_n(whole.Diagonal(i), Cholesky::kBlockSize, shared.Diagonal(i));
  }
  for (int p = 0; p < static_cast<int>(pairs.size()); ++p) {
    std::copy_n(whole.OffDiagonal(p), Cholesky::kBlockSize, shared.OffDiagonal(p));
  }
  ASSERT_TRUE(whole.Factor(0.5));
  const Eigen::VectorXd b = Eigen::VectorXd::Random(dense.rows());
  Eigen::VectorXd expected = b;
  whole.Solve(expected.data());
  int calls_before = std::numeric_limits<int>::max();
  for (const double share : {1., 1e4, 1e9}) {
    shared.BeginFactor(0.5);
    int calls = 1;
    while (shared.GoOn(share) == Cholesky::Progress::kUnderWay) ++calls;
    EXPECT_LT(calls, calls_before);
    calls_before = calls;
    Eigen::VectorXd x = b;
    shared.Solve(x.data());
    EXPECT_EQ(x, expected);
  }
  EXPECT_EQ(calls_before, 1);
}

// One supernode would be one share.
TYPED_TEST(BlockCholeskyTest, SharesOfAFullMatrixAreSmall) {
  this->Fill(100, Complete(100), &this->cholesky_);
  this->cholesky_.BeginFactor(0);
  int calls = 1;
  while (this->cholesky_.GoOn(1) == BlockCholesky<TestFixture::B>::Progress::kUnderWay) ++calls;
  EXPECT_GT(calls, 5);
}

TYPED_TEST(BlockCholeskyTest, AnIndefiniteMatrixIsRefused) {
  constexpr int kBlock = TypeParam::kSize;
  for (int trial = 0; trial < 40; ++trial) {
    const int n = 1 + trial;
    const Eigen::MatrixXd dense =
        this->Fill(n, RandomPairs(n, 2 * n, &this->rng_), &this->cholesky_);
    ASSERT_TRUE(this->cholesky_.Factor(0));
    // A shift of one block past its Schur complement: one eigenvalue falls below zero.
    const double smallest = 1 / dense.inverse()(0, 0);
    const double diagonal = this->cholesky_.Diagonal(0)[0];
    this->cholesky_.Diagonal(0)[0] = diagonal - 1.001 * smallest;
    EXPECT_FALSE(this->cholesky_.Factor(0)) << n;
    this->cholesky_.Diagonal(0)[0] = diagonal - 0.9 * smallest;
    EXPECT_TRUE(this->cholesky_.Factor(0)) << n;
    this->cholesky_.Diagonal(0)[0] = diagonal;
    this->cholesky_.Diagonal(n - 1)[kBlock + 1] = -1;
    EXPECT_FALSE(this->cholesky_.Factor(0)) << n;
    EXPECT_FALSE(this->cholesky_.Factor(1e12)) << n;
  }
}

// Springs between nodes and none to the ground: singular, until it is damped.
TYPED_TEST(BlockCholeskyTest, ASingularMatrixIsRefusedUntilItIsDamped) {
  constexpr int kBlock = TypeParam::kSize;
  using Matrix = Eigen::Matrix<double, kBlock, kBlock>;
  const Pairs pairs = Grid(5, 5);
  this->cholesky_.Analyze(25, pairs);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(25 * kBlock, 25 * kBlock);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Matrix A = this->RandomBlock(), stiffness = A.transpose() * A + Matrix::Identity();
    const int at[2] = {pairs[p].first * kBlock, pairs[p].second * kBlock};
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        dense.template block<kBlock, kBlock>(at[a], at[b]) += a == b ? stiffness : -stiffness;
      }
    }
    Eigen::Map<Matrix>(this->cholesky_.OffDiagonal(static_cast<int>(p))) = -stiffness;
  }
  for (int i = 0; i < 25; ++i) {
    Eigen::Map<Matrix>(this->cholesky_.Diagonal(i)) =
        dense.template block<kBlock, kBlock>(i * kBlock, i * kBlock);
  }
  EXPECT_FALSE(this->cholesky_.Factor(0));
  EXPECT_TRUE(this->cholesky_.Factor(1e-3));
  dense.diagonal() *= 1 + 1e-3;
  this->CheckSolution(dense, this->cholesky_);
}

TYPED_TEST(BlockCholeskyTest, ANanIsRefused) {
  for (const int node : {0, 4, 8}) {
    this->Fill(9, Grid(3, 3), &this->cholesky_);
    this->cholesky_.Diagonal(node)[0] = std::nan("");
    EXPECT_FALSE(this->cholesky_.Factor(0)) << node;
  }
  this->Fill(9, Grid(3, 3), &this->cholesky_);
  this->cholesky_.OffDiagonal(5)[1] = std::nan("");
  EXPECT_FALSE(this->cholesky_.Factor(0));
}

}  // namespace
}  // namespace hpgo
