// Engines by name.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "hpgo/solve/engine.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// "ceres", "block"; nothing for any other name.
const char* EngineName(Engine engine);
std::optional<Engine> ParseEngine(const std::string& name);

template <typename G>
std::unique_ptr<SubproblemSolver<G>> MakeSolver(Engine engine);

}  // namespace hpgo
