// A map from 64-bit ids to indices whose insertions never copy what is there: ids come in small
// pages, so that both dense and sparse ones are compact, and no update pays for a rehash.
#pragma once

#include <array>
#include <cstdint>
#include <map>

namespace hpgo {

class IdMap {
 public:
  static constexpr std::int32_t kAbsent = -1;

  std::int32_t Find(std::int64_t id) const {
    const auto it = pages_.find(id >> kPageBits);
    return it == pages_.end() ? kAbsent : it->second.values[id & kMask];
  }
  // `value` must not be kAbsent.
  void Set(std::int64_t id, std::int32_t value) {
    Page& page = pages_[id >> kPageBits];
    std::int32_t& slot = page.values[id & kMask];
    page.used += slot == kAbsent;
    slot = value;
  }
  void Erase(std::int64_t id) {
    const auto it = pages_.find(id >> kPageBits);
    if (it == pages_.end() || it->second.values[id & kMask] == kAbsent) return;
    it->second.values[id & kMask] = kAbsent;
    if (--it->second.used == 0) pages_.erase(it);
  }
  void Clear() { pages_.clear(); }
  // visit(id, value) in ascending order of ids.
  template <typename Visitor>
  void ForEach(Visitor&& visit) const {
    for (const auto& [key, page] : pages_) {
      for (std::int64_t k = 0; k <= kMask; ++k) {
        if (page.values[k] != kAbsent) visit(key * (kMask + 1) + k, page.values[k]);
      }
    }
  }
  std::size_t MemoryBytes() const { return pages_.size() * (sizeof(Page) + 48); }

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.pages_);
  }

 private:
  static constexpr int kPageBits = 5;
  static constexpr std::int64_t kMask = (std::int64_t{1} << kPageBits) - 1;
  struct Page {
    Page() { values.fill(kAbsent); }
    std::array<std::int32_t, kMask + 1> values;
    std::int32_t used = 0;

    template <typename Archive, typename Self>
    static void Fields(Archive& archive, Self& self) {
      archive(self.values, self.used);
    }
  };
  std::map<std::int64_t, Page> pages_;
};

}  // namespace hpgo
