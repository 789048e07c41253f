#include "hpgo/solve/elimination_order.h"

#include <array>
#include <cstdlib>
#include <mutex>
#include <utility>

#include "amd.h"
#include "cholmod.h"
#include "glog/logging.h"

namespace hpgo {
namespace {

// Neighbours of each row, as compressed columns.
struct Adjacency {
  int n = 0;
  std::vector<int> begin, neighbour;

  Adjacency(int rows, const std::vector<std::pair<int, int>>& pairs)
      : n(rows), begin(rows + 1, 0), neighbour(2 * pairs.size() + 1) {
    for (const auto& [i, j] : pairs) {
      ++begin[i];
      ++begin[j];
    }
    int sum = 0;
    for (int& count : begin) sum += std::exchange(count, sum);
    std::vector<int> fill(begin.begin(), begin.end() - 1);
    for (const auto& [i, j] : pairs) {
      neighbour[fill[i]++] = j;
      neighbour[fill[j]++] = i;
    }
  }
};

// METIS seeds and draws from rand(), and sets handlers of signals: all of that belongs to the
// process. So one thread at a time, and the caller's sequence goes on as if nothing had been drawn.
// The numbers that it draws from outlive the call: whoever changes the state from another thread
// meanwhile may hold on to them.
class MetisSession {
 public:
  MetisSession() : lock_(mutex_), outer_(initstate(1, state_.data(), state_.size())) {}
  MetisSession(const MetisSession&) = delete;
  MetisSession& operator=(const MetisSession&) = delete;
  ~MetisSession() { setstate(outer_); }

 private:
  static inline std::mutex mutex_;
  static inline std::array<char, 128> state_;
  const std::lock_guard<std::mutex> lock_;
  char* const outer_;
};

// Nested dissection; `order` stays as it is if that fails.
void OrderByMetis(Adjacency* adjacency, std::vector<int>* order) {
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = adjacency->n;
  matrix.nzmax = adjacency->begin.back();
  matrix.p = adjacency->begin.data();
  matrix.i = adjacency->neighbour.data();
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_PATTERN;
  matrix.packed = 1;
  std::vector<int> found(order->size());
  cholmod_common common;
  cholmod_start(&common);
  bool ok;
  {
    const MetisSession session;
    ok = cholmod_metis(&matrix, nullptr, 0, 1, found.data(), &common) != 0;
  }
  cholmod_finish(&common);
  if (ok) {
    *order = std::move(found);
  } else {
    LOG(WARNING) << "METIS failed; the order is AMD's";
  }
}

// The rows in the order of their elimination.
std::vector<int> Order(Adjacency* adjacency) {
  // Of AMD's factor, operations a number. METIS gains nothing at 20 and two thirds at 100.
  constexpr double kDense = 30;
  constexpr int kLarge = 1000;  // smaller ones take longer to dissect than to factor
  std::vector<int> order(adjacency->n + 1);
  double info[AMD_INFO];
  const int status = amd_order(adjacency->n, adjacency->begin.data(), adjacency->neighbour.data(),
                               order.data(), nullptr, info);
  CHECK_GE(status, AMD_OK) << "AMD failed";
  order.resize(adjacency->n);
  if (adjacency->n >= kLarge && info[AMD_NMULTSUBS_LDL] > kDense * info[AMD_LNZ]) {
    OrderByMetis(adjacency, &order);
  }
  return order;
}

// The elimination tree, by rows with path compression.
std::vector<int> EliminationTree(const Adjacency& adjacency, const std::vector<int>& order,
                                 const std::vector<int>& position) {
  std::vector<int> parent(adjacency.n, -1), ancestor(adjacency.n, -1);
  for (int k = 0; k < adjacency.n; ++k) {
    for (int e = adjacency.begin[order[k]]; e < adjacency.begin[order[k] + 1]; ++e) {
      for (int i = position[adjacency.neighbour[e]]; i < k && i != -1;) {
        const int up = ancestor[i];
        ancestor[i] = k;
        if (up == -1) parent[i] = k;
        i = up;
      }
    }
  }
  return parent;
}

// Place -> its place in a postorder of the tree, children in ascending order.
std::vector<int> Postorder(const std::vector<int>& parent) {
  const int n = static_cast<int>(parent.size());
  std::vector<int> first(n, -1), sibling(n, -1), post(n), stack;
  for (int k = n - 1; k >= 0; --k) {
    if (parent[k] < 0) continue;
    sibling[k] = first[parent[k]];
    first[parent[k]] = k;
  }
  int count = 0;
  for (int root = 0; root < n; ++root) {
    if (parent[root] >= 0) continue;
    stack.push_back(root);
    while (!stack.empty()) {
      const int k = stack.back();
      if (first[k] >= 0) {
        stack.push_back(first[k]);
        first[k] = sibling[first[k]];
      } else {
        post[k] = count++;
        stack.pop_back();
      }
    }
  }
  return post;
}

}  // namespace

EliminationOrder FindEliminationOrder(int n, const std::vector<std::pair<int, int>>& pairs) {
  Adjacency adjacency(n, pairs);
  const std::vector<int> order = Order(&adjacency);
  EliminationOrder result;
  result.position.resize(n);
  for (int k = 0; k < n; ++k) result.position[order[k]] = k;
  const std::vector<int> parent = EliminationTree(adjacency, order, result.position);
  const std::vector<int> post = Postorder(parent);
  result.parent.resize(n);
  for (int k = 0; k < n; ++k) result.parent[post[k]] = parent[k] < 0 ? -1 : post[parent[k]];
  for (int& p : result.position) p = post[p];
  return result;
}

}  // namespace hpgo
