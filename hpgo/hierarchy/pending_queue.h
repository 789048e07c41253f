// The pending edges of a level, largest first, to within a factor of the square root of two.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>

namespace hpgo {

// Edges wait in lists by the exponent and the first bit of the mantissa of their pending, oldest
// first, linked through the edges themselves. Every operation is O(1) and touches no more than two
// other edges: an ordered tree, exact in its order, took a quarter of an update's time.
//
// `Edges` is indexed by int32 and its elements have the fields pending (positive), queue_next,
// queue_prev (int32) and queued (bool); the last three belong to this class.
class PendingQueue {
 public:
  using Index = std::int32_t;
  static constexpr Index kNone = -1;

  PendingQueue() {
    heads_.fill(kNone);
    tails_.fill(kNone);
  }
  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }

  template <typename Edges>
  void Insert(Index e, Edges& edges) {
    auto& edge = edges[e];
    const int list = ListOf(edge.pending);
    edge.queued = true;
    edge.queue_next = kNone;
    edge.queue_prev = tails_[list];
    if (tails_[list] == kNone) {
      heads_[list] = e;
      used_[list / 64] |= std::uint64_t{1} << list % 64;
    } else {
      edges[tails_[list]].queue_next = e;
    }
    tails_[list] = e;
    ++size_;
  }

  // The edge must be queued, with the pending it was inserted with.
  template <typename Edges>
  void Erase(Index e, Edges& edges) {
    auto& edge = edges[e];
    const int list = ListOf(edge.pending);
    if (edge.queue_prev == kNone) {
      heads_[list] = edge.queue_next;
    } else {
      edges[edge.queue_prev].queue_next = edge.queue_next;
    }
    if (edge.queue_next == kNone) {
      tails_[list] = edge.queue_prev;
    } else {
      edges[edge.queue_next].queue_prev = edge.queue_prev;
    }
    if (heads_[list] == kNone) used_[list / 64] &= ~(std::uint64_t{1} << list % 64);
    edge.queued = false;
    --size_;
  }

  // Gives an edge another pending, and its place: in the queue only above `threshold`.
  template <typename Edges>
  void Update(Index e, float pending, float threshold, Edges& edges) {
    auto& edge = edges[e];
    const bool queue = pending > threshold;
    if (edge.queued && queue && ListOf(edge.pending) == ListOf(pending)) {
      edge.pending = pending;
      return;
    }
    if (edge.queued) Erase(e, edges);
    edge.pending = pending;
    if (queue) Insert(e, edges);
  }

  // The oldest edge of the list of the largest; kNone if empty.
  Index Largest() const {
    for (int word = kNumLists / 64 - 1; word >= 0; --word) {
      if (used_[word] != 0) return heads_[word * 64 + 63 - __builtin_clzll(used_[word])];
    }
    return kNone;
  }

  // visit(edge) for all, largest lists first.
  template <typename Edges, typename Visitor>
  void ForEach(const Edges& edges, Visitor&& visit) const {
    for (int list = kNumLists - 1; list >= 0; --list) {
      for (Index e = heads_[list]; e != kNone; e = edges[e].queue_next) visit(e);
    }
  }

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.heads_, self.tails_, self.used_, self.size_);
  }

 private:
  static constexpr int kNumLists = 512;  // 8 bits of exponent, 1 of mantissa
  static int ListOf(float pending) {
    std::uint32_t bits;
    std::memcpy(&bits, &pending, sizeof(bits));
    return static_cast<int>(bits >> 22) & (kNumLists - 1);
  }

  std::array<Index, kNumLists> heads_, tails_;
  std::array<std::uint64_t, kNumLists / 64> used_{};
  std::size_t size_ = 0;
};

}  // namespace hpgo
