// The program: finds the command, sets its flags, runs it, and turns whatever goes wrong into a
// message and an exit code.
#include <cstdio>
#include <exception>
#include <map>
#include <new>
#include <string>
#include <vector>

#include "gflags/gflags.h"
#include "glog/logging.h"
#include "hpgo/io/output_file.h"
#include "tools/command_line.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/signals.h"

DECLARE_int32(v);

namespace hpgo_cli {
namespace {

void StartLogging(const char* program) {
  FLAGS_logtostderr = true;
  FLAGS_minloglevel = google::GLOG_WARNING;
  google::InitGoogleLogging(program);
}

const Command* FindCommand(const std::string& name) {
  for (const Command* command : AllCommands()) {
    if (command->name == name) return command;
  }
  return nullptr;
}

// An output that cannot be written is found before the work is done.
hpgo::Status CheckOutputs(const Command& command) {
  std::map<std::string, std::string> flags;  // by path
  for (const std::string& flag : command.flags) {
    if (!IsOutputFlag(flag)) continue;
    std::string path;
    if (!gflags::GetCommandLineOption(flag.c_str(), &path) || path.empty()) continue;
    const auto [other, is_new] = flags.emplace(path, flag);
    if (!is_new && path != "-") {
      return hpgo::Status(hpgo::StatusCode::kInvalidArgument,
                          "--" + other->second + " and --" + flag + " cannot be the same file");
    }
    const hpgo::Status status = hpgo::CheckOutputPath(path);
    if (!status.ok()) return status;
  }
  return hpgo::Status::Ok();
}

int RunCommand(const Command& command, const std::vector<std::string>& arguments) {
  const ParsedArguments parsed = ParseArguments(command, arguments);
  if (parsed.help) {
    std::fputs(CommandHelp(command).c_str(), stdout);
    return kExitOk;
  }
  if (!parsed.error.empty()) {
    Error(parsed.error + "; see hpgo " + command.name + " --help");
    return kExitUsage;
  }
  // VLOG writes at the level INFO, which is off unless it is asked for.
  if (FLAGS_v > 0) FLAGS_minloglevel = google::GLOG_INFO;
  const hpgo::Status outputs = CheckOutputs(command);
  if (!outputs.ok()) return Fail(outputs);
  InstallSignalHandlers();
  return command.run(parsed.positional);
}

int Run(const std::vector<std::string>& arguments) {
  const std::string& name = arguments.empty() ? "" : arguments[0];
  if (name == "--help" || name == "-h" || name == "-help" ||
      (name == "help" && arguments.size() == 1)) {
    std::fputs(ProgramHelp(AllCommands()).c_str(), stdout);
    return kExitOk;
  }
  if (name == "--version" || name == "-version") {
    Print("hpgo " HPGO_VERSION);
    return kExitOk;
  }
  if (name.empty()) {
    std::fputs(ProgramHelp(AllCommands()).c_str(), stderr);
    return kExitUsage;
  }
  const bool asks_help = name == "help";
  const Command* command = FindCommand(asks_help ? arguments[1] : name);
  if (command == nullptr) {
    Error("no command '" + (asks_help ? arguments[1] : name) + "'; hpgo --help lists them");
    return kExitUsage;
  }
  if (asks_help) return RunCommand(*command, {"--help"});
  return RunCommand(*command, {arguments.begin() + 1, arguments.end()});
}

int RunAndReport(const std::vector<std::string>& arguments) {
  int code = kExitNoSolution;
  try {
    code = Run(arguments);
  } catch (const std::bad_alloc&) {
    Error("out of memory");
  } catch (const std::exception& error) {
    Error(std::string("internal error: ") + error.what());
  }
  // A full disk behind stdout must not end as success.
  if ((std::fflush(stdout) != 0 || std::ferror(stdout) != 0) && code == kExitOk) {
    Error("cannot write to the standard output");
    code = kExitUnreadable;
  }
  return code;
}

}  // namespace
}  // namespace hpgo_cli

int main(int argc, char** argv) {
  hpgo_cli::StartLogging(argv[0]);
  return hpgo_cli::RunAndReport({argv + 1, argv + argc});
}
