// What a subcommand of `hpgo` is, and what its file may use of the program around it.
#pragma once

#include <string>
#include <vector>

namespace hpgo_cli {

// Exit codes: a contract with scripts.
enum ExitCode {
  kExitOk = 0,
  kExitUsage = 1,
  kExitUnreadable = 2,
  kExitMalformed = 3,
  kExitNoSolution = 4,
  kExitLimit = 5,       // a limit was hit and a usable result written
  kExitComparison = 6,  // a comparison failed its threshold
  kExitInterrupted = 130,
};

// One subcommand: one file, cmd_NAME.cc, that defines `const Command& NAMECommand()`.
struct Command {
  std::string name;
  std::string arguments;  // as shown in the usage line: "INPUT [OTHER]"
  std::string summary;    // one sentence
  int min_arguments = 1;
  int max_arguments = 1;
  std::vector<std::string> flags;  // the gflags this command takes; any other is a usage error
  int (*run)(const std::vector<std::string>& arguments);  // returns an ExitCode
  std::string help;  // more text for --help: what is printed, examples
};

}  // namespace hpgo_cli
