#include "test/tools/run_program.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

// A terminal's two ends.
struct Terminal {
  int master = -1;
  int slave = -1;
};

Terminal OpenTerminal() {
  Terminal terminal;
  terminal.master = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal.master < 0) return terminal;
  const bool ready = grantpt(terminal.master) == 0 && unlockpt(terminal.master) == 0;
  const char* name = ready ? ptsname(terminal.master) : nullptr;
  if (name != nullptr) terminal.slave = open(name, O_RDWR | O_NOCTTY);
  return terminal;
}

// What is written to the terminal until its other end is closed.
std::string ReadTerminal(int master) {
  std::string text;
  char buffer[4096];
  for (ssize_t count; (count = read(master, buffer, sizeof(buffer))) > 0;) {
    text.append(buffer, static_cast<std::size_t>(count));
  }
  return text;
}

[[noreturn]] void Exec(const std::vector<std::string>& arguments,
                       const std::vector<std::string>& environment) {
  for (const std::string& variable : environment) putenv(const_cast<char*>(variable.c_str()));
  std::vector<char*> argv = {const_cast<char*>(HPGO_PROGRAM)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(HPGO_PROGRAM, argv.data());
  _exit(127);
}

// The program's stdin: a file, or where a signal is to come first a pipe that `writer` fills.
int OpenInput(const TemporaryDirectory& directory, const ProgramOptions& options, int* writer) {
  if (options.signal == 0) return open(directory.Write("in", options.input).c_str(), O_RDONLY);
  int ends[2] = {-1, -1};
  EXPECT_EQ(pipe2(ends, O_CLOEXEC), 0);
  *writer = ends[1];
  return ends[0];
}

void SendSignals(pid_t child, const ProgramOptions& options) {
  // Time to start and to wait for the input, and between two signals to handle the first.
  for (int k = 0; k < options.signal_count; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    EXPECT_EQ(kill(child, options.signal), 0);
  }
}

void WriteAndClose(int fd, const std::string& text) {
  // Where the program is gone, writing fails, as it should.
  signal(SIGPIPE, SIG_IGN);
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t count = write(fd, text.data() + done, text.size() - done);
    if (count <= 0) break;
    done += static_cast<std::size_t>(count);
  }
  close(fd);
}

}  // namespace

ProgramResult RunProgram(const std::vector<std::string>& arguments, const ProgramOptions& options) {
  const TemporaryDirectory directory;
  const std::string err_path = directory.File("err");
  const std::string out_path =
      options.stdout_path.empty() ? directory.File("out") : options.stdout_path;
  int pipe_in = -1;
  const int in = OpenInput(directory, options, &pipe_in);
  const int out = open(out_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  EXPECT_GE(in, 0);
  EXPECT_GE(out, 0);
  Terminal terminal;
  if (options.stderr_is_terminal) terminal = OpenTerminal();
  EXPECT_TRUE(!options.stderr_is_terminal || terminal.slave >= 0);
  const int err = options.stderr_is_terminal
                      ? terminal.slave
                      : open(err_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);

  const pid_t child = fork();
  if (child == 0) {
    dup2(in, STDIN_FILENO);
    dup2(out, STDOUT_FILENO);
    dup2(err, STDERR_FILENO);
    for (const int fd : {in, out, err, terminal.master}) close(fd);
    Exec(arguments, options.environment);
  }
  EXPECT_GT(child, 0);
  for (const int fd : {in, out, err}) close(fd);
  if (options.signal != 0) SendSignals(child, options);
  if (options.signal != 0) WriteAndClose(pipe_in, options.input);
  ProgramResult result;
  if (options.stderr_is_terminal) {
    result.err = ReadTerminal(terminal.master);
    close(terminal.master);
  }
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (options.stdout_path.empty()) result.out = ReadFile(out_path);
  if (!options.stderr_is_terminal) result.err = ReadFile(err_path);
  return result;
}

bool HasTerminals() {
  const Terminal terminal = OpenTerminal();
  for (const int fd : {terminal.master, terminal.slave}) {
    if (fd >= 0) close(fd);
  }
  return terminal.slave >= 0;
}

TemporaryDirectory::TemporaryDirectory() {
  std::string pattern = ::testing::TempDir() + "hpgo_test_XXXXXX";
  EXPECT_NE(mkdtemp(pattern.data()), nullptr);
  path_ = pattern;
}

TemporaryDirectory::~TemporaryDirectory() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryDirectory::Write(const std::string& name, const std::string& text) const {
  std::ofstream(File(name), std::ios::binary) << text;
  return File(name);
}

std::vector<std::string> TemporaryDirectory::List() const {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path_)) {
    names.push_back(entry.path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::string ReadFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace hpgo
