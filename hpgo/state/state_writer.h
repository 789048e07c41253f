// Takes objects apart into bytes that are the same on every machine.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <vector>

#include "hpgo/graph/status.h"
#include "hpgo/state/state_objects.h"
#include "hpgo/state/state_traits.h"

namespace hpgo {

// A class lists its fields once, for this and for StateReader:
//
//   template <typename Archive, typename Self>
//   static void Fields(Archive& archive, Self& self) {
//     archive(self.pose, self.children);
//   }
//
// Numbers are little-endian; containers give their size first, and unordered ones go by their keys.
// Not synchronized.
class StateWriter {
 public:
  // Gets the bytes of a section in blocks that end between two numbers.
  using Sink = std::function<void(const char* section, std::string_view bytes)>;
  // Losses go by their names, which others than those of ceres_costs::MakeLoss have not; and costs
  // of the caller's own have none. With `objects` both go there, and must come from there.
  explicit StateWriter(Sink sink, StateObjects* objects = nullptr);
  StateWriter(const StateWriter&) = delete;
  StateWriter& operator=(const StateWriter&) = delete;

  bool shares_objects() const { return objects_ != nullptr; }
  // Begins a section; its name, of up to 8 letters, must live on.
  void Section(const char* name);
  template <typename... Values>
  void operator()(const Values&... values) {
    (Put(values), ...);
  }
  // Ends the last section. kInvalidArgument for an object without a name.
  Status Finish();

 private:
  static constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

  template <typename T>
  void Put(const T& value) {
    if constexpr (std::is_enum_v<T>) {
      PutNumber(static_cast<std::underlying_type_t<T>>(value));
    } else if constexpr (std::is_arithmetic_v<T>) {
      PutNumber(static_cast<StoredNumber<T>>(value));
    } else if constexpr (std::is_same_v<T, std::shared_ptr<const ceres::LossFunction>>) {
      PutLoss(value);
    } else if constexpr (std::is_same_v<T, std::shared_ptr<const ceres::CostFunction>>) {
      PutCost(value);
    } else if constexpr (IsOwner<T>::value) {
      Put(value != nullptr);
      if (value != nullptr) Put(*value);
    } else if constexpr (IsPair<T>::value) {
      Put(value.first);
      Put(value.second);
    } else if constexpr (IsFixedMatrix<T>::value) {
      for (int k = 0; k < T::SizeAtCompileTime; ++k) Put(value.data()[k]);
    } else if constexpr (IsArray<T>::value) {
      for (const auto& element : value) Put(element);
    } else if constexpr (IsSequence<T>::value) {
      Put(std::uint64_t{value.size()});
      for (std::size_t k = 0; k < value.size(); ++k) Put(value[k]);
    } else if constexpr (IsSet<T>::value) {
      Put(std::uint64_t{value.size()});
      for (const auto& key : value) Put(key);
    } else if constexpr (IsMap<T>::value) {
      PutSorted(value);
    } else {
      T::Fields(*this, value);
    }
  }

  template <typename Map>
  void PutSorted(const Map& map) {
    Put(std::uint64_t{map.size()});
    std::vector<const typename Map::value_type*> entries;
    entries.reserve(map.size());
    for (const auto& entry : map) entries.push_back(&entry);
    std::sort(entries.begin(), entries.end(),
              [](const auto* a, const auto* b) { return a->first < b->first; });
    for (const auto* entry : entries) {
      Put(entry->first);
      Put(entry->second);
    }
  }

  template <typename T>
  void PutNumber(T value) {
    if (kBlockBytes - size_ < sizeof(T)) Flush();
    StoreNumber(value, &buffer_[size_]);
    size_ += sizeof(T);
  }

  void PutLoss(const std::shared_ptr<const ceres::LossFunction>& loss);
  void PutCost(const std::shared_ptr<const ceres::CostFunction>& cost);
  void Flush();

  const Sink sink_;
  StateObjects* const objects_;
  const char* section_ = nullptr;
  std::unique_ptr<char[]> buffer_;
  std::size_t size_ = 0;                                                  // of what is in it
  std::unordered_map<const ceres::LossFunction*, std::uint32_t> losses_;  // -> numbers from 1 on
  Status status_;
};

}  // namespace hpgo
