#include "hpgo/io/input_text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

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

// A buffer that grows.
class Buffer {
 public:
  explicit Buffer(std::size_t capacity) : data_(new char[capacity]), capacity_(capacity) {}

  // Where to write next, and how much may be written there: at least one byte.
  char* end() { return data_.get() + size_; }
  std::size_t room() {
    if (size_ == capacity_) {
      // Not make_unique: it would fill the buffer with zeros.
      std::unique_ptr<char[]> larger(new char[2 * capacity_]);
      std::copy(data_.get(), data_.get() + size_, larger.get());
      data_ = std::move(larger);
      capacity_ *= 2;
    }
    return capacity_ - size_;
  }
  void Added(std::size_t count) { size_ += count; }
  std::string_view text() const { return std::string_view(data_.get(), size_); }
  std::unique_ptr<char[]> Release() { return std::move(data_); }

 private:
  std::unique_ptr<char[]> data_;
  std::size_t size_ = 0;
  std::size_t capacity_;
};

bool IsGzip(std::string_view text) {
  return text.size() > 1 && text[0] == '\x1f' && text[1] == '\x8b';
}

// Unpacks all members of a gzip file; zeros may fill it up, as tapes do.
Status Unpack(std::string_view packed, const std::string& name, Buffer* out) {
  const auto malformed = [&name](const char* what) {
    return Status(StatusCode::kMalformed, name + ": compressed with gzip, " + what);
  };
  z_stream stream = {};
  constexpr int kGzipOnly = 16;
  if (inflateInit2(&stream, MAX_WBITS + kGzipOnly) != Z_OK) return malformed("cannot be unpacked");
  const std::unique_ptr<z_stream, int (*)(z_stream*)> guard(&stream, inflateEnd);
  constexpr std::size_t kPiece = 1 << 30;  // zlib counts in 32 bits
  for (;;) {
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    stream.avail_in = static_cast<uInt>(std::min(packed.size(), kPiece));
    const std::size_t room = std::min(out->room(), kPiece);
    stream.next_out = reinterpret_cast<Bytef*>(out->end());
    stream.avail_out = static_cast<uInt>(room);
    const std::size_t given = stream.avail_in;
    const int state = inflate(&stream, Z_NO_FLUSH);
    packed.remove_prefix(given - stream.avail_in);
    out->Added(room - stream.avail_out);
    if (state == Z_STREAM_END) {
      packed.remove_prefix(std::min(packed.find_first_not_of('\0'), packed.size()));
      if (packed.empty()) return Status::Ok();
      if (!IsGzip(packed)) return malformed("but something else follows");
      if (inflateReset(&stream) != Z_OK) return malformed("cannot be unpacked");
    } else if (state == Z_BUF_ERROR || (state == Z_OK && packed.empty() && stream.avail_out > 0)) {
      return malformed("but the data ends early");
    } else if (state != Z_OK) {
      return malformed("but damaged");
    }
  }
}

}  // namespace

Result<InputText> InputText::Read(const std::string& path) {
  InputText input;
  const bool standard = path == "-";
  input.name_ = standard ? "stdin" : path.empty() ? "''" : path;
  const Descriptor file(standard ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) return Unreadable(input.name_, "cannot be opened");
  struct stat info;
  // One byte more than a regular file has: the read that fills it also sees the end.
  const bool sized = fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0;
  Buffer buffer(sized ? static_cast<std::size_t>(info.st_size) + 1 : kFirstBuffer);
  for (;;) {
    const std::size_t room = buffer.room();
    const ssize_t got = read(file.get(), buffer.end(), room);
    if (got == 0) break;
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return Unreadable(input.name_, "cannot be read");
    buffer.Added(static_cast<std::size_t>(got));
  }
  if (IsGzip(buffer.text())) {
    Buffer unpacked(4 * buffer.text().size() + 1);
    const Status status = Unpack(buffer.text(), input.name_, &unpacked);
    if (!status.ok()) return status;
    buffer = std::move(unpacked);
  }
  input.size_ = buffer.text().size();
  input.data_ = buffer.Release();
  return input;
}

std::string_view InputText::text() const {
  return WithoutByteOrderMark(std::string_view(data_.get(), size_));
}

bool HasFileMark(std::string_view text) {
  return IsGzip(text) || WithoutByteOrderMark(text).size() < text.size();
}

std::string_view WithoutByteOrderMark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.substr(0, kMark.size()) == kMark ? text.substr(kMark.size()) : text;
}

}  // namespace hpgo
