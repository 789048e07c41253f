// Which kind of field a type is, and the bytes of a number, for the archives of a state.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <utility>

namespace hpgo {

template <typename T, typename = void>
struct IsFixedMatrix : std::false_type {};  // Eigen's
template <typename T>
struct IsFixedMatrix<T, std::void_t<decltype(T::SizeAtCompileTime)>>
    : std::bool_constant<(T::SizeAtCompileTime > 0)> {};

template <typename T>
struct IsOwner : std::false_type {};
template <typename T>
struct IsOwner<std::unique_ptr<T>> : std::true_type {};
template <typename T>
struct IsOwner<std::shared_ptr<T>> : std::true_type {};

template <typename T>
struct IsArray : std::is_array<T> {};
template <typename T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};

template <typename T>
struct IsPair : std::false_type {};
template <typename A, typename B>
struct IsPair<std::pair<A, B>> : std::true_type {};

// Indexed from 0, and grows at its end.
template <typename T, typename = void>
struct IsSequence : std::false_type {};
template <typename T>
struct IsSequence<T, std::void_t<decltype(std::declval<const T&>().size()),
                                 decltype(std::declval<T&>().push_back(
                                     std::declval<const T&>()[std::size_t{0}]))>> : std::true_type {
};

template <typename T, typename = void>
struct IsMap : std::false_type {};
template <typename T>
struct IsMap<T, std::void_t<typename T::mapped_type>> : std::true_type {};

template <typename T, typename = void>
struct IsSet : std::false_type {};
template <typename T>
struct IsSet<T, std::void_t<typename T::key_type>> : std::negation<IsMap<T>> {};

// The unsigned integer that holds a number. Sizes are 8 bytes wide on every machine, truth values
// one.
template <std::size_t kBytes>
using UnsignedOfSize = std::conditional_t<
    kBytes == 1, std::uint8_t,
    std::conditional_t<kBytes == 2, std::uint16_t,
                       std::conditional_t<kBytes == 4, std::uint32_t, std::uint64_t>>>;
template <typename T>
using StoredNumber =
    std::conditional_t<std::is_same_v<T, std::size_t>, std::uint64_t,
                       std::conditional_t<std::is_same_v<T, bool>, std::uint8_t, T>>;

// sizeof(T) bytes, little-endian.
template <typename T>
void StoreNumber(T value, char* bytes) {
  UnsignedOfSize<sizeof(T)> bits;
  std::memcpy(&bits, &value, sizeof(T));
  for (std::size_t k = 0; k < sizeof(T); ++k) {
    bytes[k] = static_cast<char>(bits >> (8 * k) & 0xff);
  }
}
template <typename T>
T LoadNumber(const char* bytes) {
  using Bits = UnsignedOfSize<sizeof(T)>;
  Bits bits = 0;
  for (std::size_t k = 0; k < sizeof(T); ++k) {
    const Bits byte = static_cast<unsigned char>(bytes[k]);
    bits = static_cast<Bits>(bits | byte << (8 * k));
  }
  T value;
  std::memcpy(&value, &bits, sizeof(T));
  return value;
}

}  // namespace hpgo
