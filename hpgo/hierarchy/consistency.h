// Checks every invariant of a hierarchy: for tests, after every step. O(nodes + edges).
#pragma once

#include <string>

#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

// Empty if all is well, else the first thing wrong: links, adjacency, degrees, weights, parents,
// group sizes and connectedness, lifted edges, fixed counts, finite unit poses, the pending sets.
template <typename G>
std::string FindInconsistency(const Hierarchy<G>& hierarchy);

}  // namespace hpgo
