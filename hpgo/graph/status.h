// Recoverable errors: bad files, bad options, no solution. Programmer errors use glog's CHECK.
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace hpgo {

enum class StatusCode {
  kOk,
  kInvalidArgument,  // the caller's value is out of range or inconsistent
  kNotFound,         // no such node, edge or prior
  kAlreadyExists,    // the id is taken
  kUnreadable,       // a file cannot be opened, read or written
  kMalformed,        // a file's content is wrong; the message names the line
  kNoSolution,       // a solve failed; the estimate is as it was before
  kInterrupted,      // cancelled by the caller
};

// The name of a code, as "not found".
const char* StatusCodeName(StatusCode code);

// Success, or a code with a message that names the node, edge, file or line at fault.
class [[nodiscard]] Status {
 public:
  Status() = default;
  Status(StatusCode code, std::string message) : code_(code), message_(std::move(message)) {}
  static Status Ok() { return Status(); }

  bool ok() const { return code_ == StatusCode::kOk; }
  StatusCode code() const { return code_; }
  const std::string& message() const { return message_; }
  // "ok", or "not found: no node 7".
  std::string ToString() const;

 private:
  StatusCode code_ = StatusCode::kOk;
  std::string message_;
};

// A value, or the Status that says why there is none. value() requires ok().
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}          // NOLINT: implicit by design
  Result(Status status) : status_(std::move(status)) {}  // NOLINT: implicit by design
  bool ok() const { return value_.has_value(); }
  const Status& status() const { return status_; }
  const T& value() const& { return value_.value(); }
  T& value() & { return value_.value(); }
  T&& value() && { return std::move(value_).value(); }
  const T& operator*() const { return *value_; }
  T& operator*() { return *value_; }
  const T* operator->() const { return &*value_; }
  T* operator->() { return &*value_; }

 private:
  std::optional<T> value_;
  Status status_;
};

}  // namespace hpgo
