// Files of an Optimizer's whole state; STATE.md says what is in them.
#pragma once

#include <string>
#include <string_view>

#include "hpgo/optimizer.h"

namespace hpgo {

// Raised with every change of what is written.
inline constexpr unsigned kStateVersion = 9;

// Writes the file completely or not at all; see OutputFile for paths. What went in last stays under
// its name until then. Errors: those of Optimizer::Save, and kUnreadable.
template <typename G>
Status SaveState(const Optimizer<G>& optimizer, const std::string& path);

// Replaces the optimizer, its options too; an error leaves it as it was. kUnreadable; kMalformed
// with what is wrong with the file: no state, of another version, of poses of another kind, damaged
// (every change of up to four neighbouring bytes is found, and nearly every other) or cut off.
// Memory: that of the file besides.
template <typename G>
Status LoadState(const std::string& path, Optimizer<G>* optimizer);

// The same from the bytes of such a file; messages are without its name.
template <typename G>
Status ParseState(std::string_view bytes, Optimizer<G>* optimizer);

}  // namespace hpgo
