#include "hpgo/io/input_text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace hpgo {
namespace {

constexpr std::size_t kFirstBuffer = 1 << 16;

// Closes a descriptor that it was given, unless it is the standard input.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ > STDIN_FILENO) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

Status Unreadable(const std::string& name, const char* what) {
  return Status(StatusCode::kUnreadable, name + ": " + what + ": " + std::strerror(errno));
}

}  // namespace

Result<InputText> InputText::Read(const std::string& path) {
  InputText input;
  const bool standard = path == "-";
  input.name_ = standard ? "stdin" : path;
  const Descriptor file(standard ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return Unreadable(input.name_, "cannot be opened");
  struct stat info;
  // One byte more than a regular file has: the read that fills it also sees the end.
  const bool sized = fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0;
  std::size_t capacity = sized ? static_cast<std::size_t>(info.st_size) + 1 : kFirstBuffer;
  input.data_.reset(new char[capacity]);  // not make_unique: it would fill the buffer with zeros
  for (;;) {
    const ssize_t got = read(file.get(), input.data_.get() + input.size_, capacity - input.size_);
    if (got == 0) return input;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Unreadable(input.name_, "cannot be read");
    input.size_ += static_cast<std::size_t>(got);
    if (input.size_ < capacity) continue;
    capacity *= 2;
    std::unique_ptr<char[]> larger(new char[capacity]);
    std::copy(input.data_.get(), input.data_.get() + input.size_, larger.get());
    input.data_ = std::move(larger);
  }
}

std::string_view InputText::text() const {
  return WithoutByteOrderMark(std::string_view(data_.get(), size_));
}

std::string_view WithoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.substr(0, kMark.size()) == kMark ? text.substr(kMark.size()) : text;
}

}  // namespace hpgo
