// What the program says: messages, warnings and errors on stderr, results on stdout. Colours and
// the progress line only on a terminal.
#pragma once

#include <cstdint>
#include <string>

#include "hpgo/graph/status.h"

namespace hpgo_cli {

// A line on stderr; nothing under --quiet.
void Message(const std::string& text);
// A line "warning: text" on stderr, under --quiet too.
void Warn(const std::string& text);
// A line "error: text" on stderr.
void Error(const std::string& text);
// A line on stdout: a result that a script may read.
void Print(const std::string& text);

// Prints the error and returns the exit code that stands for it.
int Fail(const hpgo::Status& status);
// A wrong value on the command line: prints it with a hint at --help; returns kExitUsage.
int FailUsage(const std::string& text);

// One line on stderr that is overwritten at every call; nothing where stderr is not a terminal or
// under --quiet. The line is erased when the object goes, so that the next message has the place.
class Progress {
 public:
  Progress();
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  // Shown at most 20 times a second.
  void Show(const std::string& text);
  bool enabled() const { return enabled_; }

 private:
  bool enabled_;
  bool shown_ = false;
  double last_seconds_ = -1;
};

// Emphasis for a message on stderr; returns the text as it is where colours are off.
std::string Bold(const std::string& text);
std::string Green(const std::string& text);
std::string Red(const std::string& text);
std::string Dim(const std::string& text);

// "1,234,567".
std::string FormatCount(std::int64_t value);
// Seven significant digits, "14574.75"; "1.2387e+12" where very large or small.
std::string FormatNumber(double value);
// "0.82 ms", "1.24 s", "3 min 05 s".
std::string FormatDuration(double seconds);
// "1 node", "2 nodes", "1,000 nodes".
std::string Plural(std::int64_t count, const std::string& noun);

}  // namespace hpgo_cli
