// What the tests of full solves share.
#pragma once

#include <cstring>

#include "hpgo/solve/engine.h"

namespace hpgo {

inline constexpr Engine kEngines[] = {Engine::kCeres, Engine::kBlock};

template <typename G>
bool SameBits(const G& a, const G& b) {
  return std::memcmp(a.data(), b.data(), sizeof(double) * G::kParams) == 0;
}

}  // namespace hpgo
