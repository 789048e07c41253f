// Ctrl-C (and SIGTERM): once asks the running command to finish and write what there is, a second
// time kills.
#pragma once

#include <atomic>

namespace hpgo_cli {

// Set by the first signal; pass its address as the solvers' `cancel`.
std::atomic<bool>& CancelFlag();

void InstallSignalHandlers();

}  // namespace hpgo_cli
