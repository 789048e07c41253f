// Sparse Cholesky factorization of a symmetric positive definite matrix of small dense blocks, one
// block row a node: ordered by blocks, supernodal, left-looking.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace hpgo {

// Blocks are kBlock x kBlock, column-major; kBlock is 3, 4 or 6. Not synchronized; keeps its
// storage between uses.
template <int kBlock>
class BlockCholesky {
 public:
  static constexpr int kBlockSize = kBlock * kBlock;

  // Orders and analyzes a matrix of n block rows, whose blocks off the diagonal are those of
  // `pairs` and their transposes. Pairs may be in any order and direction and must be distinct,
  // with first != second. The same again costs nothing. Sets all values to zero.
  void Analyze(int n, const std::vector<std::pair<int, int>>& pairs);

  // The values to fill in before Factor: the diagonal block of node i, and the block of pair p in
  // the direction (row first[p], column second[p]).
  double* Diagonal(int i) { return &values_[static_cast<std::size_t>(i) * kBlockSize]; }
  double* OffDiagonal(int p) { return &values_[(n_ + static_cast<std::size_t>(p)) * kBlockSize]; }
  void SetZero();

  // Factors A + lambda diag(A). False if that is not numerically positive definite: a pivot fell
  // below 1e-14 of its diagonal entry. The values stay.
  bool Factor(double lambda) {
    BeginFactor(lambda);
    return GoOn(std::numeric_limits<double>::infinity()) == Progress::kDone;
  }

  // The same in shares: GoOn returns once it has multiplied about so many numbers, and is called
  // again until it is done or has failed. In between the values must not change.
  enum class Progress { kUnderWay, kDone, kFailed };
  void BeginFactor(double lambda);
  Progress GoOn(double multiplications);

  // Solves with the factor in place; x holds n blocks of kBlock numbers.
  void Solve(double* x) const;

  // Numbers in the factor, padding included.
  std::int64_t factor_size() const { return factor_size_; }

  // What a saved state has of it: the matrix. Loaded, it is to be resumed before anything else.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.n_, self.pairs_, self.values_);
  }
  // Orders and analyzes what was loaded. False if that is no matrix.
  bool Resume();
  int num_rows() const { return n_; }  // in blocks

 private:
  void Order(const std::vector<std::pair<int, int>>& pairs);
  void FindSupernodes();
  void FindRows();
  void PlaceValues(const std::vector<std::pair<int, int>>& pairs);
  void FillPanel(int s);
  void BeginPanel(int s);
  double UpdateFrom(int descendant);
  void Update(int s, int descendant, int first_row, int num_columns);
  void Queue(int descendant);

  int Width(int s) const { return super_begin_[s + 1] - super_begin_[s]; }
  int Rows(int s) const { return static_cast<int>(rows_begin_[s + 1] - rows_begin_[s]); }

  struct Target {
    std::int64_t offset;  // of the block's corner in factor_
    int ld;
    bool transposed;
  };

  int n_ = -1;                              // none analyzed yet
  std::vector<std::pair<int, int>> pairs_;  // of the last Analyze
  std::vector<int> position_;               // node -> its place in the elimination order
  std::vector<int> below_begin_, below_;    // place -> the later places of its neighbours
  std::vector<int> parent_;                 // of the elimination tree, by place
  std::vector<int> super_begin_;            // supernode -> its first place
  std::vector<int> super_of_;               // place -> supernode
  std::vector<std::int64_t> rows_begin_;    // supernode -> its places in rows_, its own first
  std::vector<int> rows_;
  std::vector<std::int64_t> panel_begin_;  // supernode -> its panel in factor_
  std::vector<int> panel_ld_;
  std::vector<Target> targets_;             // where each block of values_ goes
  std::vector<int> filled_begin_, filled_;  // supernode -> the blocks of values_ in its panel
  std::vector<double> values_;
  std::unique_ptr<double[]> factor_;  // a panel is set where it is factored, and not before
  std::int64_t factor_size_ = 0, capacity_ = 0;

  // Of the factorization under way: the supernode, and the descendant that goes into it next.
  double lambda_ = 0;
  int super_ = 0, descendant_ = -1;
  std::vector<int> next_, next_row_, head_, map_;
  std::vector<double> update_, min_pivot_;
  mutable std::vector<double> work_, rows_work_;  // workspace of Solve
};

extern template class BlockCholesky<3>;
extern template class BlockCholesky<4>;
extern template class BlockCholesky<6>;

}  // namespace hpgo
