// Poses by node in a map whose versions share what they have in common.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// A version of the map: copying it is O(1), and it never changes. Pages of 32 poses hang in a radix
// tree over the ids, so that dense ids and sparse ones are compact and are visited in order. Any
// number of threads may read one version, and drop it.
template <typename G>
class PoseMap {
 public:
  // Null if there is no such node; valid as long as this version, or a copy of it, lives.
  const G* Find(NodeId id) const;
  std::size_t size() const { return size_; }
  // visit(id, pose) in ascending order of ids.
  template <typename Visitor>
  void ForEach(Visitor&& visit) const {
    if (root_ != nullptr) Visit(*root_, visit);
  }

 private:
  template <typename>
  friend class PoseMapWriter;

  static constexpr int kBits = 5, kWidth = 1 << kBits;
  struct Node {
    Node(int s, std::uint64_t p) : shift(s), prefix(p) {}
    Node(const Node&) = default;
    Node& operator=(const Node&) = delete;
    virtual ~Node() = default;
    bool Covers(std::uint64_t key) const {
      return shift < 0 ? key == prefix : shift + kBits >= 64 || key >> (shift + kBits) == prefix;
    }
    std::uint64_t edit = 0;  // of the writer that made it, and may still change it
    int shift;               // of the digit that chooses a child; negative: a page
    std::uint64_t prefix;    // of the keys below; of a page, the key
  };
  struct Page : Node {
    explicit Page(std::uint64_t key) : Node(-1, key) {}
    std::uint32_t used = 0;  // one bit a slot
    std::array<G, kWidth> poses;
  };
  struct Inner : Node {
    using Node::Node;
    std::array<std::shared_ptr<Node>, kWidth> children;
  };

  // Keys are in the order of ids, negative ones first.
  static std::uint64_t Ordered(NodeId id) {
    return static_cast<std::uint64_t>(id) ^ (std::uint64_t{1} << 63);
  }
  static std::uint64_t KeyOf(NodeId id) { return Ordered(id) >> kBits; }
  static int SlotOf(NodeId id) { return static_cast<int>(Ordered(id) & (kWidth - 1)); }
  static NodeId IdOf(std::uint64_t key, int slot) {
    return static_cast<NodeId>((key << kBits | static_cast<std::uint64_t>(slot)) ^
                               (std::uint64_t{1} << 63));
  }

  template <typename Visitor>
  static void Visit(const Node& node, Visitor& visit) {
    if (node.shift < 0) {
      const Page& page = static_cast<const Page&>(node);
      for (int slot = 0; slot < kWidth; ++slot) {
        if (page.used >> slot & 1) visit(IdOf(page.prefix, slot), page.poses[slot]);
      }
      return;
    }
    for (const std::shared_ptr<Node>& child : static_cast<const Inner&>(node).children) {
      if (child != nullptr) Visit(*child, visit);
    }
  }

  std::shared_ptr<Node> root_;
  std::size_t size_ = 0;
};

// Makes the versions. A change copies the pages and the paths to them that earlier versions hold,
// once a version: O(changes) between two calls of Publish. One thread at a time.
template <typename G>
class PoseMapWriter {
 public:
  void Set(NodeId id, const G& pose);
  void Erase(NodeId id);
  void Clear() { map_ = PoseMap<G>(); }
  // The map as it is now.
  PoseMap<G> Publish() {
    ++edit_;
    return map_;
  }

 private:
  using Map = PoseMap<G>;
  using Node = typename Map::Node;
  using Page = typename Map::Page;
  using Inner = typename Map::Inner;

  // Makes the node one that no version holds.
  Node& Own(std::shared_ptr<Node>* at) const;
  void SetBelow(std::shared_ptr<Node>* at, std::uint64_t key, int slot, const G& pose);
  void EraseBelow(std::shared_ptr<Node>* at, std::uint64_t key, int slot);

  Map map_;
  std::uint64_t edit_ = 1;
};

extern template class PoseMap<SE2>;
extern template class PoseMap<SE3>;
extern template class PoseMap<YawPose>;
extern template class PoseMapWriter<SE2>;
extern template class PoseMapWriter<SE3>;
extern template class PoseMapWriter<YawPose>;

}  // namespace hpgo
