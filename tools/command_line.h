// Splits a command's arguments into flags and positional arguments. gflags holds the flags; this
// decides which of them a command takes, so that another command's flag is an error.
#pragma once

#include <string>
#include <vector>

#include "tools/command.h"

namespace hpgo_cli {

struct ParsedArguments {
  std::vector<std::string> positional;
  bool help = false;
  std::string error;  // empty: fine
};

// Sets the gflags named in `arguments` (--name=value, --name value, --bool, --nobool; one dash is
// as good as two). "--" ends the flags; "-" alone is positional. Not thread safe.
ParsedArguments ParseArguments(const Command& command, const std::vector<std::string>& arguments);

// The text of `hpgo COMMAND --help`: usage, summary, the command's own flags with their defaults.
std::string CommandHelp(const Command& command);
// The text of `hpgo --help`.
std::string ProgramHelp(const std::vector<const Command*>& commands);

}  // namespace hpgo_cli
