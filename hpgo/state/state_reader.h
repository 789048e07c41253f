// Puts together what StateWriter has taken apart.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "hpgo/graph/status.h"
#include "hpgo/state/state_objects.h"
#include "hpgo/state/state_traits.h"

namespace hpgo {

// Asked in the order in which it was written, into new objects. After a failure all numbers are 0
// and all containers are empty; sizes are taken for true only as far as there are bytes. Not
// synchronized.
class StateReader {
 public:
  struct Block {
    std::string_view section, bytes;  // valid until the next one; no section: the end
  };
  using Source = std::function<Result<Block>()>;
  // `objects`: those of the writer, if it had some.
  explicit StateReader(Source source, const StateObjects* objects = nullptr);
  StateReader(const StateReader&) = delete;
  StateReader& operator=(const StateReader&) = delete;

  // The section before must have been read to its end.
  void Section(std::string_view name);
  template <typename... Values>
  void operator()(Values&... values) {
    (Get(&values), ...);
  }
  // Nothing must be left. The first failure: one of the source, kMalformed if what is there is
  // something else than what was asked for, kInvalidArgument for a loss that is not known.
  Status Finish();
  bool ok() const { return status_.ok(); }

 private:
  template <typename T>
  void Get(T* value) {
    if constexpr (std::is_enum_v<T>) {
      *value = static_cast<T>(GetNumber<std::underlying_type_t<T>>());
    } else if constexpr (std::is_same_v<T, bool>) {
      *value = GetNumber<std::uint8_t>() != 0;
    } else if constexpr (std::is_arithmetic_v<T>) {
      *value = static_cast<T>(GetNumber<StoredNumber<T>>());
    } else if constexpr (std::is_same_v<T, std::shared_ptr<const ceres::LossFunction>>) {
      GetLoss(value);
    } else if constexpr (std::is_same_v<T, std::shared_ptr<const ceres::CostFunction>>) {
      GetCost(value);
    } else if constexpr (IsOwner<T>::value) {
      GetOwned(value);
    } else if constexpr (IsPair<T>::value) {
      Get(&value->first);
      Get(&value->second);
    } else if constexpr (IsFixedMatrix<T>::value) {
      for (int k = 0; k < T::SizeAtCompileTime; ++k) Get(&value->data()[k]);
    } else if constexpr (IsArray<T>::value) {
      for (auto& element : *value) Get(&element);
    } else if constexpr (IsSequence<T>::value) {
      using Element = std::decay_t<decltype((*value)[0])>;
      *value = T();
      ForEachOfCount([&] {
        Element element{};
        Get(&element);
        value->push_back(std::move(element));
      });
    } else if constexpr (IsSet<T>::value) {
      value->clear();
      ForEachOfCount([&] {
        typename T::key_type key{};
        Get(&key);
        value->insert(value->end(), key);
      });
    } else if constexpr (IsMap<T>::value) {
      value->clear();
      ForEachOfCount([&] {
        typename T::key_type key{};
        typename T::mapped_type mapped{};
        Get(&key);
        Get(&mapped);
        value->emplace(key, std::move(mapped));
      });
    } else {
      T::Fields(*this, *value);
    }
  }

  template <typename Owner>
  void GetOwned(Owner* owner) {
    using Object = std::remove_const_t<typename Owner::element_type>;
    owner->reset();
    if (GetNumber<std::uint8_t>() == 0) return;
    auto object = std::make_unique<Object>();
    Get(object.get());
    *owner = std::move(object);
  }

  template <typename Element>
  void ForEachOfCount(Element&& element) {
    for (auto count = GetNumber<std::uint64_t>(); count > 0 && ok(); --count) element();
  }

  template <typename T>
  T GetNumber() {
    if (bytes_.size() < sizeof(T) && !Refill(sizeof(T))) return T();
    const T value = LoadNumber<T>(bytes_.data());
    bytes_.remove_prefix(sizeof(T));
    return value;
  }

  void GetLoss(std::shared_ptr<const ceres::LossFunction>* loss);
  void GetCost(std::shared_ptr<const ceres::CostFunction>* cost);
  // The next block of the section; false if there are not so many bytes for a number.
  bool Refill(std::size_t width);
  void Fail(StatusCode code, const std::string& message);
  Block Next();

  const Source source_;
  const StateObjects* const objects_;
  std::string section_;
  std::string_view bytes_;  // of the block, that have not been read
  std::vector<std::shared_ptr<const ceres::LossFunction>> losses_;
  std::size_t num_costs_ = 0;
  Status status_;
};

}  // namespace hpgo
