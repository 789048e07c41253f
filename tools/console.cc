#include "tools/console.h"

#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tools/command.h"
#include "tools/common_flags.h"

namespace hpgo_cli {
namespace {

// A terminal that understands escape sequences.
bool IsTerminal() {
  static const bool is_terminal = [] {
    const char* term = std::getenv("TERM");
    return isatty(STDERR_FILENO) != 0 && !(term != nullptr && std::strcmp(term, "dumb") == 0);
  }();
  return is_terminal;
}

// https://no-color.org: any value that is not empty switches colours off.
bool UsesColor() {
  static const bool uses_color = [] {
    const char* no_color = std::getenv("NO_COLOR");
    return IsTerminal() && (no_color == nullptr || no_color[0] == '\0');
  }();
  return uses_color;
}

std::string Styled(const char* code, const std::string& text) {
  if (!UsesColor()) return text;
  return std::string("\033[") + code + "m" + text + "\033[0m";
}

void WriteLine(std::FILE* stream, const std::string& text) {
  const std::string line = text + "\n";
  std::fwrite(line.data(), 1, line.size(), stream);
}

double Now() {
  using Clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(Clock::now().time_since_epoch()).count();
}

int ExitCodeOf(hpgo::StatusCode code) {
  switch (code) {
    case hpgo::StatusCode::kOk:
      return kExitOk;
    case hpgo::StatusCode::kInvalidArgument:
    case hpgo::StatusCode::kNotFound:
    case hpgo::StatusCode::kAlreadyExists:
      return kExitUsage;
    case hpgo::StatusCode::kUnreadable:
      return kExitUnreadable;
    case hpgo::StatusCode::kMalformed:
      return kExitMalformed;
    case hpgo::StatusCode::kNoSolution:
      return kExitNoSolution;
    case hpgo::StatusCode::kInterrupted:
      return kExitInterrupted;
  }
  return kExitUsage;
}

}  // namespace

void Message(const std::string& text) {
  if (!FLAGS_quiet) WriteLine(stderr, text);
}

void Warn(const std::string& text) { WriteLine(stderr, Styled("33", "warning:") + " " + text); }

void Error(const std::string& text) { WriteLine(stderr, Styled("1;31", "error:") + " " + text); }

void Print(const std::string& text) { WriteLine(stdout, text); }

int Fail(const hpgo::Status& status) {
  Error(status.message().empty() ? status.ToString() : status.message());
  return ExitCodeOf(status.code());
}

int FailUsage(const std::string& text) {
  Error(text + " (see --help)");
  return kExitUsage;
}

Progress::Progress() : enabled_(IsTerminal() && !FLAGS_quiet) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::Show(const std::string& text) {
  constexpr double kMinSeconds = 0.05;
  if (!enabled_ || (shown_ && Now() - last_seconds_ < kMinSeconds)) return;
  last_seconds_ = Now();
  shown_ = true;
  std::fprintf(stderr, "\r\033[K%s", text.c_str());
  std::fflush(stderr);
}

std::string Bold(const std::string& text) { return Styled("1", text); }
std::string Green(const std::string& text) { return Styled("32", text); }
std::string Red(const std::string& text) { return Styled("31", text); }
std::string Dim(const std::string& text) { return Styled("2", text); }

std::string FormatCount(std::int64_t value) {
  std::string digits = std::to_string(value);
  const int first = value < 0 ? 1 : 0;
  for (int place = static_cast<int>(digits.size()) - 3; place > first; place -= 3) {
    digits.insert(place, ",");
  }
  return digits;
}

std::string FormatNumber(double value) {
  char text[32];
  const double size = std::abs(value);
  const bool plain = size == 0 || (size >= 1e-4 && size < 1e9) || !std::isfinite(value);
  std::snprintf(text, sizeof(text), plain ? "%.*f" : "%.*e",
                !plain                   ? 4
                : size >= 1000           ? 2
                : size >= 1 || size == 0 ? 4
                                         : 6,
                value);
  return text;
}

std::string FormatDuration(double seconds) {
  char text[48];
  if (seconds < 1) {
    std::snprintf(text, sizeof(text), "%.3g ms", seconds * 1e3);
  } else if (seconds < 60) {
    std::snprintf(text, sizeof(text), "%.3g s", seconds);
  } else {
    const auto whole = static_cast<std::int64_t>(std::llround(seconds));
    std::snprintf(text, sizeof(text), "%lld min %02lld s", static_cast<long long>(whole / 60),
                  static_cast<long long>(whole % 60));
  }
  return text;
}

std::string Plural(std::int64_t count, const std::string& noun) {
  return FormatCount(count) + " " + noun + (count == 1 ? "" : "s");
}

}  // namespace hpgo_cli
