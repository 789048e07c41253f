// Which poses the factors of a problem do not determine.
#pragma once

#include <vector>

#include "hpgo/solve/subproblem.h"

namespace hpgo {

// The free poses, ascending, that can move in some direction without a change of the linearized
// objective: the factors hold them there neither to a constant pose nor to the world. Only
// semi-definite information and custom costs let that happen where a chain of factors leads from
// every pose to one that is held, as it must here: without any such, the answer is none at next to
// no cost, else it takes two factorizations. Losses are left out: what they reject counts as
// measured. Empty where a custom cost fails.
template <typename G>
std::vector<int> FindUndetermined(const Subproblem<G>& problem);

}  // namespace hpgo
