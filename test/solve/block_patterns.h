// Pairs of the blocks off the diagonal that are not zero: patterns for the tests of BlockCholesky.
#pragma once

#include <algorithm>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace hpgo {

using Pairs = std::vector<std::pair<int, int>>;

inline Pairs Chain(int n) {
  Pairs pairs;
  for (int i = 1; i < n; ++i) pairs.emplace_back(i - 1, i);
  return pairs;
}

inline Pairs Star(int n, int centre) {
  Pairs pairs;
  for (int i = 0; i < n; ++i) {
    if (i != centre) pairs.emplace_back(i, centre);
  }
  return pairs;
}

inline Pairs Complete(int n) {
  Pairs pairs;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) pairs.emplace_back(i, j);
  }
  return pairs;
}

inline Pairs Grid(int rows, int cols) {
  Pairs pairs;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) {
      if (c > 0) pairs.emplace_back(r * cols + c, r * cols + c - 1);
      if (r > 0) pairs.emplace_back((r - 1) * cols + c, r * cols + c);
    }
  }
  return pairs;
}

// Distinct pairs in any order and direction.
inline Pairs RandomPairs(int n, int count, std::mt19937* rng) {
  std::set<std::pair<int, int>> seen;
  Pairs pairs;
  std::uniform_int_distribution<int> node(0, n - 1);
  for (int trial = 0; trial < count; ++trial) {
    const int i = node(*rng), j = node(*rng);
    if (i != j && seen.insert(std::minmax(i, j)).second) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace hpgo
