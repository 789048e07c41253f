// A whole file in memory.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "hpgo/graph/status.h"

namespace hpgo {

// Movable; views stay valid when it is moved.
class InputText {
 public:
  // `path` may be "-", the standard input. What gzip compressed is unpacked. kUnreadable, with the
  // path and the system's reason; kMalformed where compressed data is damaged or ends early.
  static Result<InputText> Read(const std::string& path);

  // Without a byte order mark.
  std::string_view text() const;
  // The name for messages: the path, or "stdin".
  const std::string& name() const { return name_; }

 private:
  std::unique_ptr<char[]> data_;
  std::size_t size_ = 0;
  std::string name_;
};

// Whether a file that begins so is not read as it stands: after a byte order mark, or as gzip.
bool HasFileMark(std::string_view text);

// Without a UTF-8 byte order mark.
std::string_view WithoutByteOrderMark(std::string_view text);

}  // namespace hpgo
