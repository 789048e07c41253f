#include "tools/command_line.h"

#include <algorithm>
#include <sstream>

#include "gflags/gflags.h"

namespace hpgo_cli {
namespace {

constexpr std::size_t kHelpWidth = 80;

// The flags that every command takes.
const std::vector<std::string>& SharedFlags() {
  static const auto* flags = new std::vector<std::string>{"quiet", "v"};
  return *flags;
}

bool Takes(const Command& command, const std::string& flag) {
  const auto in = [&flag](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), flag) != list.end();
  };
  return in(command.flags) || in(SharedFlags());
}

// "words words" broken into lines of kHelpWidth, each indented.
std::string Wrapped(const std::string& text, const std::string& indent) {
  std::istringstream words(text);
  std::string result, line = indent, word;
  while (words >> word) {
    if (line.size() > indent.size() && line.size() + 1 + word.size() > kHelpWidth) {
      result += line + "\n";
      line = indent;
    }
    line += (line.size() > indent.size() ? " " : "") + word;
  }
  return result + line + "\n";
}

// gflags prints 0.005 with all 17 digits.
std::string ShortNumber(const std::string& digits) {
  std::ostringstream text;
  text.precision(12);
  text << std::stod(digits);
  return text.str();
}

std::string FlagHelp(const std::string& name) {
  gflags::CommandLineFlagInfo info;
  if (!gflags::GetCommandLineFlagInfo(name.c_str(), &info)) return "";
  // The only flag that is not ours.
  if (name == "v") info.description = "log what the solvers do to stderr, more with 2 and 3";
  std::string head = "  --" + name;
  std::string preset = info.default_value;
  if (info.type == "double") preset = ShortNumber(preset);
  if (info.type == "string") {
    head += "=TEXT";
    preset = preset.empty() ? "" : "default: " + preset;
  } else if (info.type == "bool") {
    preset = preset == "true" ? "default: on; --no" + name + " switches it off" : "";
  } else {
    head += "=NUMBER";
    preset = "default: " + preset;
  }
  return head + "\n" +
         Wrapped(info.description + (preset.empty() ? "" : " (" + preset + ")"), "      ");
}

struct Flag {
  std::string name;
  std::string value;
  bool has_value = false;
};

// "--name=value" or "-name"; `argument` begins with a dash.
Flag SplitFlag(const std::string& argument) {
  const std::string body = argument.substr(argument[1] == '-' ? 2 : 1);
  const std::size_t equals = body.find('=');
  if (equals == std::string::npos) return {body, "", false};
  return {body.substr(0, equals), body.substr(equals + 1), true};
}

}  // namespace

ParsedArguments ParseArguments(const Command& command, const std::vector<std::string>& arguments) {
  ParsedArguments parsed;
  bool only_positional = false;
  for (std::size_t k = 0; k < arguments.size(); ++k) {
    const std::string& argument = arguments[k];
    if (only_positional || argument.size() < 2 || argument[0] != '-') {
      parsed.positional.push_back(argument);
      continue;
    }
    if (argument == "--") {
      only_positional = true;
      continue;
    }
    Flag flag = SplitFlag(argument);
    if (flag.name == "help" || flag.name == "h") {
      parsed.help = true;
      return parsed;
    }
    gflags::CommandLineFlagInfo info;
    if (!Takes(command, flag.name) && flag.name.compare(0, 2, "no") == 0 && !flag.has_value &&
        Takes(command, flag.name.substr(2))) {
      flag = {flag.name.substr(2), "false", true};
    }
    if (!Takes(command, flag.name) || !gflags::GetCommandLineFlagInfo(flag.name.c_str(), &info)) {
      parsed.error = "hpgo " + command.name + " has no flag --" + flag.name;
      return parsed;
    }
    if (!flag.has_value) {
      if (info.type == "bool") {
        flag.value = "true";
      } else if (k + 1 < arguments.size()) {
        flag.value = arguments[++k];
      } else {
        parsed.error = "--" + flag.name + " needs a value";
        return parsed;
      }
    }
    if (gflags::SetCommandLineOption(flag.name.c_str(), flag.value.c_str()).empty()) {
      parsed.error = "--" + flag.name + ": '" + flag.value + "' is not a valid value (" +
                     (info.type == "string" ? "text" : info.type) + ")";
      return parsed;
    }
  }
  const int count = static_cast<int>(parsed.positional.size());
  if (count < command.min_arguments || count > command.max_arguments) {
    parsed.error = "hpgo " + command.name + " takes " +
                   (command.arguments.empty() ? "no arguments" : command.arguments) + ", but " +
                   std::to_string(count) + (count == 1 ? " argument was" : " arguments were") +
                   " given";
  }
  return parsed;
}

std::string CommandHelp(const Command& command) {
  std::string text = "Usage: hpgo " + command.name + " " + command.arguments +
                     (command.arguments.empty() ? "" : " ") + "[--flag=value]...\n\n";
  text += Wrapped(command.summary, "");
  if (!command.help.empty())
    text += "\n" + command.help + (command.help.back() == '\n' ? "" : "\n");
  text += "\nFlags:\n";
  for (const std::string& flag : command.flags) {
    if (flag != "quiet" && flag != "v") text += FlagHelp(flag);
  }
  for (const std::string& flag : SharedFlags()) text += FlagHelp(flag);
  return text;
}

std::string ProgramHelp(const std::vector<const Command*>& commands) {
  std::string text =
      "Usage: hpgo COMMAND [arguments] [--flag=value]...\n\n"
      "Pose graph optimization over files, in 2D and 3D.\n\nCommands:\n";
  for (const Command* command : commands) {
    std::string name = "  " + command->name;
    name.resize(std::max<std::size_t>(name.size() + 2, 14), ' ');
    const std::string summary = Wrapped(command->summary, std::string(name.size(), ' '));
    text += name + summary.substr(name.size());
  }
  text +=
      "\nhpgo COMMAND --help explains a command and lists its flags.\n"
      "\nA file named - is the standard input or output. Messages go to stderr, results to\n"
      "the files named or to stdout. Ctrl-C once finishes and writes what there is.\n"
      "\nExit codes: 0 ok, 1 usage, 2 a file cannot be read or written, 3 malformed input,\n"
      "4 no usable solution, 5 a limit was hit and a usable result written, 6 a comparison\n"
      "failed its threshold, 130 interrupted.\n";
  return text;
}

}  // namespace hpgo_cli
