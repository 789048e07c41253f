#include "hpgo/io/output_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace hpgo {
namespace {

constexpr std::size_t kBufferSize = 1 << 20;
constexpr int kOpenFlags = O_WRONLY | O_CREAT | O_CLOEXEC;
constexpr mode_t kNewFileMode = 0666;  // less the user's mask

std::string DirectoryOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "./" : path.substr(0, slash + 1);
}

// Where the links at `path` lead; `path` itself where nothing exists yet.
std::string Resolve(const std::string& path) {
  const std::unique_ptr<char, void (*)(void*)> real(realpath(path.c_str(), nullptr), std::free);
  return real ? std::string(real.get()) : path;
}

}  // namespace

OutputFile::OutputFile(const std::string& path) : path_(path) {
  if (path == "-") {
    fd_ = STDOUT_FILENO;
    return;
  }
  struct stat info;
  const bool exists = stat(path.c_str(), &info) == 0;
  if (exists && !S_ISREG(info.st_mode)) {
    fd_ = open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd_ < 0) Fail("cannot be written");
    return;
  }
  target_ = Resolve(path);
  OpenTemporary();
  // A file system without modes is no reason to fail.
  if (fd_ >= 0 && exists && fchmod(fd_, info.st_mode & 07777) != 0) errno = 0;
}

OutputFile::~OutputFile() { Discard(); }

void OutputFile::OpenTemporary() {
  static std::atomic<int> counter{0};
  do {
    temporary_ = DirectoryOf(target_) + ".hpgo-" + std::to_string(getpid()) + "-" +
                 std::to_string(counter++) + ".tmp";
    fd_ = open(temporary_.c_str(), kOpenFlags | O_EXCL, kNewFileMode);
  } while (fd_ < 0 && errno == EEXIST);
  if (fd_ >= 0) return;
  temporary_.clear();
  Fail("cannot be created");
}

void OutputFile::Fail(const char* what) {
  if (!status_.ok()) return;
  const std::string name = path_ == "-" ? "stdout" : path_;
  status_ = Status(StatusCode::kUnreadable, name + ": " + what + ": " + std::strerror(errno));
}

void OutputFile::Discard() {
  if (fd_ > STDERR_FILENO) close(fd_);
  fd_ = -1;
  if (!temporary_.empty()) unlink(temporary_.c_str());
  temporary_.clear();
}

void OutputFile::Flush() {
  std::string_view rest = buffer_;
  while (status_.ok() && !rest.empty()) {
    const ssize_t written = write(fd_, rest.data(), rest.size());
    if (written >= 0) {
      rest.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      Fail("cannot be written");
    }
  }
  buffer_.clear();
}

void OutputFile::FlushIfLarge() {
  if (buffer_.size() >= kBufferSize) Flush();
}

void OutputFile::Append(std::string_view text) {
  buffer_ += text;
  FlushIfLarge();
}

Status OutputFile::Commit() {
  Flush();
  if (status_.ok() && !temporary_.empty()) {
    if (fsync(fd_) != 0) Fail("cannot be written");
    if (close(fd_) != 0) Fail("cannot be written");
    fd_ = -1;
    if (status_.ok() && std::rename(temporary_.c_str(), target_.c_str()) != 0) {
      Fail("cannot be replaced");
    }
    if (status_.ok()) {
      temporary_.clear();
      // The name, too, must survive a power failure, where the file system can promise that.
      const int directory = open(DirectoryOf(target_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      if (directory >= 0) {
        fsync(directory);
        close(directory);
      }
    }
  }
  Discard();
  return status_;
}

Status WriteTextFile(const std::string& path, std::string_view text) {
  OutputFile out(path);
  out.Append(text);
  return out.Commit();
}

}  // namespace hpgo
