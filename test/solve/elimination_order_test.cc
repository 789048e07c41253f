#include "hpgo/solve/elimination_order.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iterator>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

// A square grid whose nodes are joined to all within `reach` rows and columns.
Pairs Grid(int side, int reach) {
  Pairs pairs;
  for (int a = 0; a < side * side; ++a) {
    for (int b = a + 1; b < side * side; ++b) {
      if (b / side - a / side > reach) break;
      if (std::abs(b % side - a % side) <= reach) pairs.emplace_back(b, a);
    }
  }
  return pairs;
}

// Numbers in each column of the factor, by elimination without any cleverness.
std::vector<int> ColumnCounts(int n, const Pairs& pairs, const EliminationOrder& order,
                              std::vector<int>* parent) {
  std::vector<std::set<int>> later(n);
  for (const auto& [i, j] : pairs) {
    const auto [low, high] = std::minmax(order.position[i], order.position[j]);
    later[low].insert(high);
  }
  std::vector<int> counts(n);
  parent->assign(n, -1);
  for (int k = 0; k < n; ++k) {
    counts[k] = static_cast<int>(later[k].size());
    if (later[k].empty()) continue;
    const int next = *later[k].begin();
    (*parent)[k] = next;
    later[next].insert(std::next(later[k].begin()), later[k].end());
  }
  return counts;
}

double Operations(int n, const Pairs& pairs, const EliminationOrder& order) {
  std::vector<int> parent;
  double sum = 0;
  for (const int count : ColumnCounts(n, pairs, order, &parent)) sum += 1. * count * count;
  return sum;
}

void CheckOrder(int n, const Pairs& pairs) {
  const EliminationOrder order = FindEliminationOrder(n, pairs);
  ASSERT_EQ(order.position.size(), static_cast<std::size_t>(n));
  EXPECT_EQ(std::set<int>(order.position.begin(), order.position.end()).size(),
            static_cast<std::size_t>(n));
  std::vector<int> parent;
  ColumnCounts(n, pairs, order, &parent);
  EXPECT_EQ(order.parent, parent);
  // Postorder: a subtree's places follow one another, its root last.
  std::vector<int> first(n);
  for (int k = 0; k < n; ++k) first[k] = k;
  for (int k = 0; k < n; ++k) {
    if (parent[k] < 0) continue;
    EXPECT_GT(parent[k], k);
    first[parent[k]] = std::min(first[parent[k]], first[k]);
  }
  for (int k = 0; k + 1 < n; ++k) {
    if (parent[k] != k + 1) {
      EXPECT_EQ(first[k + 1], k + 1) << k;
    }
  }
  const EliminationOrder again = FindEliminationOrder(n, pairs);
  EXPECT_EQ(again.position, order.position);
}

TEST(EliminationOrderTest, IsAPostorderOfItsTree) {
  CheckOrder(0, {});
  CheckOrder(1, {});
  CheckOrder(5, {});
  CheckOrder(4, {{3, 0}, {1, 2}});
  CheckOrder(400, Grid(20, 1));
  CheckOrder(2500, Grid(50, 2));  // dense enough for dissection
}

TEST(EliminationOrderTest, FillsLessThanTheNaturalOrder) {
  for (const int reach : {1, 2}) {
    const Pairs pairs = Grid(50, reach);
    EliminationOrder natural;
    for (int k = 0; k < 2500; ++k) natural.position.push_back(k);
    EXPECT_LT(Operations(2500, pairs, FindEliminationOrder(2500, pairs)),
              0.7 * Operations(2500, pairs, natural));
  }
}

// METIS works with state of the process: the C library's random numbers.
TEST(EliminationOrderTest, ThreadsTakeTurns) {
  constexpr int kSide = 40, kThreads = 4, kTimes = 8;
  const Pairs pairs = Grid(kSide, 2);
  const EliminationOrder alone = FindEliminationOrder(kSide * kSide, pairs);
  std::vector<int> differ(kThreads, 0);
  std::vector<std::thread> threads;
  for (int k = 0; k < kThreads; ++k) {
    threads.emplace_back([&, k] {
      for (int time = 0; time < kTimes; ++time) {
        differ[k] += FindEliminationOrder(kSide * kSide, pairs).position != alone.position;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(differ, std::vector<int>(kThreads, 0));
}

TEST(EliminationOrderTest, TheCallersRandomNumbersGoOn) {
  const Pairs pairs = Grid(40, 2);
  srand(17);
  const int expected[2] = {rand(), rand()};
  srand(17);
  EXPECT_EQ(rand(), expected[0]);
  FindEliminationOrder(1600, pairs);
  EXPECT_EQ(rand(), expected[1]);
}

// Another thread may draw meanwhile, and keep a state of its own.
TEST(EliminationOrderTest, BearsRandomNumbersDrawnMeanwhile) {
  const Pairs pairs = Grid(40, 2);
  std::atomic<bool> done{false};
  std::thread other([&] {
    static char own[64];
    char* const before = initstate(5, own, sizeof(own));
    while (!done) rand();
    setstate(before);
  });
  for (int k = 0; k < 8; ++k) {
    const EliminationOrder order = FindEliminationOrder(1600, pairs);
    EXPECT_EQ(std::set<int>(order.position.begin(), order.position.end()).size(), 1600u);
  }
  done = true;
  other.join();
  rand();
}

}  // namespace
}  // namespace hpgo
