// Gauss-Newton, damped where needed, on the blocks of the Hessian: the fast engine.
#pragma once

#include <memory>

#include "hpgo/solve/subproblem.h"

namespace hpgo {

// A solver that linearizes factors straight into 3x3 (2D) or 6x6 (3D) blocks and factors them with
// BlockCholesky. An iteration tries the full step first and is damped (Levenberg-Marquardt) until
// the cost falls. Deterministic, single-threaded; use one per thread.
template <typename G>
std::unique_ptr<SubproblemSolver<G>> MakeBlockSolver();

}  // namespace hpgo
