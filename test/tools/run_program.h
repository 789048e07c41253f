// Runs the program as a shell would and catches what it says. For tests.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace hpgo {

struct ProgramResult {
  int exit_code = -1;  // 128 + number where a signal ended it
  std::string out;
  std::string err;
};

struct ProgramOptions {
  std::string input;                     // on stdin
  std::vector<std::string> environment;  // "NAME=value", added to this process' own
  bool stderr_is_terminal = false;
  std::string stdout_path;  // where stdout goes, instead of ProgramResult::out
  // Sent so many times while the program waits for its input, which it gets only then.
  int signal = 0;
  int signal_count = 1;
};

// `arguments` without the program's name.
ProgramResult RunProgram(const std::vector<std::string>& arguments,
                         const ProgramOptions& options = ProgramOptions());

// False where the system gives no pseudo-terminals, as in a bare chroot.
bool HasTerminals();

// A directory of this test case, empty at first, removed at exit.
class TemporaryDirectory {
 public:
  TemporaryDirectory();
  ~TemporaryDirectory();
  TemporaryDirectory(const TemporaryDirectory&) = delete;
  TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;
  std::string File(const std::string& name) const { return path_ + "/" + name; }
  // Writes a file and returns its path.
  std::string Write(const std::string& name, const std::string& text) const;
  // The names of the files in it, sorted.
  std::vector<std::string> List() const;

 private:
  std::string path_;
};

// The whole file; empty where there is none.
std::string ReadFile(const std::string& path);

}  // namespace hpgo
