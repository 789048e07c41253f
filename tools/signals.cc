#include "tools/signals.h"

#include <signal.h>
#include <unistd.h>

namespace hpgo_cli {
namespace {

std::atomic<bool> cancel_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

void OnSignal(int /*signal*/) {
  cancel_flag.store(true);
  // Only calls that are safe in a signal handler.
  constexpr char kText[] = "\ninterrupted: finishing; press Ctrl-C again to stop at once\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, kText, sizeof(kText) - 1);
}

}  // namespace

std::atomic<bool>& CancelFlag() { return cancel_flag; }

void InstallSignalHandlers() {
  struct sigaction action = {};
  action.sa_handler = OnSignal;
  // The handler runs once: the second signal meets the default action, which kills.
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

}  // namespace hpgo_cli
