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

// The links to a process' open files.
constexpr char kDescriptors[] = "/proc/self/fd/";
std::string DescriptorPath(int fd) { return kDescriptors + std::to_string(fd); }

// A name beside `target` that no other thread or process takes.
std::string TemporaryName(const std::string& target) {
  static std::atomic<int> counter{0};
  return DirectoryOf(target) + ".hpgo-" + std::to_string(getpid()) + "-" +
         std::to_string(counter++) + ".tmp";
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
    direct_ = true;
    return;
  }
  struct stat info;
  const bool exists = stat(path.c_str(), &info) == 0;
  if (exists && !S_ISREG(info.st_mode)) {
    direct_ = true;
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
  // It is through /proc that it gets its name later.
  if (access(kDescriptors, X_OK) == 0) {
    fd_ = open(DirectoryOf(target_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, kNewFileMode);
  }
  if (fd_ < 0) OpenNamedTemporary();
  if (fd_ < 0) Fail("cannot be created");
}

void OutputFile::OpenNamedTemporary() {
  do {
    temporary_ = TemporaryName(target_);
    fd_ = open(temporary_.c_str(), kOpenFlags | O_EXCL, kNewFileMode);
  } while (fd_ < 0 && errno == EEXIST);
  if (fd_ < 0) temporary_.clear();
}

// A link never replaces a file, a rename does.
void OutputFile::GiveName() {
  const std::string source = DescriptorPath(fd_);
  const auto link_to = [&source](const std::string& name) {
    return linkat(AT_FDCWD, source.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
  };
  if (temporary_.empty()) {
    if (link_to(target_)) return;
    bool linked = false;
    while (!linked && errno == EEXIST) {
      temporary_ = TemporaryName(target_);
      linked = link_to(temporary_);
    }
    if (!linked) {
      temporary_.clear();
      Fail("cannot be created");
      return;
    }
  }
  if (std::rename(temporary_.c_str(), target_.c_str()) == 0) {
    temporary_.clear();
  } else {
    Fail("cannot be replaced");
  }
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
  if (status_.ok() && !direct_) {
    if (fsync(fd_) != 0) Fail("cannot be written");
    if (status_.ok()) GiveName();
    if (close(fd_) != 0) Fail("cannot be written");
    fd_ = -1;
    if (status_.ok()) {
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

Status CheckOutputPath(const std::string& path) {
  struct stat info;
  const bool exists = path != "-" && stat(path.c_str(), &info) == 0;
  // A pipe must not be opened before there is something to write.
  if (exists && (S_ISFIFO(info.st_mode) || S_ISSOCK(info.st_mode))) return Status::Ok();
  return OutputFile(path).status();
}

Status WriteTextFile(const std::string& path, std::string_view text) {
  OutputFile out(path);
  out.Append(text);
  return out.Commit();
}

}  // namespace hpgo
