#include "hpgo/live/pose_map.h"

#include <algorithm>

namespace hpgo {

template <typename G>
const G* PoseMap<G>::Find(NodeId id) const {
  const std::uint64_t key = KeyOf(id);
  const Node* node = root_.get();
  while (node != nullptr && node->Covers(key)) {
    if (node->shift < 0) {
      const Page& page = static_cast<const Page&>(*node);
      return page.used >> SlotOf(id) & 1 ? &page.poses[SlotOf(id)] : nullptr;
    }
    node = static_cast<const Inner&>(*node).children[key >> node->shift & (kWidth - 1)].get();
  }
  return nullptr;
}

template <typename G>
typename PoseMapWriter<G>::Node& PoseMapWriter<G>::Own(std::shared_ptr<Node>* at) const {
  if ((*at)->edit != edit_) {
    if ((*at)->shift < 0) {
      *at = std::make_shared<Page>(static_cast<const Page&>(**at));
    } else {
      *at = std::make_shared<Inner>(static_cast<const Inner&>(**at));
    }
    (*at)->edit = edit_;
  }
  return **at;
}

template <typename G>
void PoseMapWriter<G>::Set(NodeId id, const G& pose) {
  SetBelow(&map_.root_, Map::KeyOf(id), Map::SlotOf(id), pose);
}

template <typename G>
void PoseMapWriter<G>::SetBelow(std::shared_ptr<Node>* at, std::uint64_t key, int slot,
                                const G& pose) {
  if (*at == nullptr) {
    *at = std::make_shared<Page>(key);
    (*at)->edit = edit_;
  }
  if (!(*at)->Covers(key)) {
    // A new node above both, at the highest digit in which they differ.
    const Node& node = **at;
    const std::uint64_t other =
        node.shift < 0 ? node.prefix : node.prefix << (node.shift + Map::kBits);
    int highest = 63;
    while (((key ^ other) >> highest & 1) == 0) --highest;
    const int shift = highest / Map::kBits * Map::kBits;
    const int above = shift + Map::kBits;
    const auto inner = std::make_shared<Inner>(shift, above >= 64 ? 0 : key >> above);
    inner->edit = edit_;
    inner->children[other >> shift & (Map::kWidth - 1)] = std::move(*at);
    *at = inner;
  }
  Node& node = Own(at);
  if (node.shift < 0) {
    Page& page = static_cast<Page&>(node);
    map_.size_ += (page.used >> slot & 1) == 0;
    page.used |= std::uint32_t{1} << slot;
    page.poses[slot] = pose;
    return;
  }
  SetBelow(&static_cast<Inner&>(node).children[key >> node.shift & (Map::kWidth - 1)], key, slot,
           pose);
}

template <typename G>
void PoseMapWriter<G>::Erase(NodeId id) {
  if (map_.Find(id) == nullptr) return;
  EraseBelow(&map_.root_, Map::KeyOf(id), Map::SlotOf(id));
  --map_.size_;
}

// The node is there.
template <typename G>
void PoseMapWriter<G>::EraseBelow(std::shared_ptr<Node>* at, std::uint64_t key, int slot) {
  Node& node = Own(at);
  if (node.shift < 0) {
    Page& page = static_cast<Page&>(node);
    page.used &= ~(std::uint32_t{1} << slot);
    if (page.used == 0) at->reset();
    return;
  }
  auto& children = static_cast<Inner&>(node).children;
  EraseBelow(&children[key >> node.shift & (Map::kWidth - 1)], key, slot);
  const auto is_there = [](const std::shared_ptr<Node>& child) { return child != nullptr; };
  const auto left = std::count_if(children.begin(), children.end(), is_there);
  if (left == 0) {
    at->reset();
  } else if (left == 1) {
    // A path does not branch: shorter without.
    std::shared_ptr<Node> only = *std::find_if(children.begin(), children.end(), is_there);
    *at = std::move(only);
  }
}

template class PoseMap<SE2>;
template class PoseMap<SE3>;
template class PoseMap<YawPose>;
template class PoseMapWriter<SE2>;
template class PoseMapWriter<SE3>;
template class PoseMapWriter<YawPose>;

}  // namespace hpgo
