// A vector that never moves its elements: appending costs the same at any size, so that no update
// pays for copying a million of them.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace hpgo {

template <typename T, std::size_t kChunkBits = 10>
class ChunkedVector {
 public:
  std::size_t size() const { return size_; }
  T& operator[](std::size_t i) { return chunks_[i >> kChunkBits][i & kMask]; }
  const T& operator[](std::size_t i) const { return chunks_[i >> kChunkBits][i & kMask]; }
  void push_back(const T& value) {
    if ((size_ & kMask) == 0 && (size_ >> kChunkBits) == chunks_.size()) {
      chunks_.emplace_back(new T[kMask + 1]);
    }
    (*this)[size_++] = value;
  }
  std::size_t MemoryBytes() const { return chunks_.size() * (kMask + 1) * sizeof(T); }

 private:
  static constexpr std::size_t kMask = (std::size_t{1} << kChunkBits) - 1;
  std::vector<std::unique_ptr<T[]>> chunks_;
  std::size_t size_ = 0;
};

}  // namespace hpgo
