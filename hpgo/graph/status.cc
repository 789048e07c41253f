#include "hpgo/graph/status.h"

namespace hpgo {

const char* StatusCodeName(StatusCode code) {
  switch (code) {
    case StatusCode::kOk:
      return "ok";
    case StatusCode::kInvalidArgument:
      return "invalid argument";
    case StatusCode::kNotFound:
      return "not found";
    case StatusCode::kAlreadyExists:
      return "already exists";
    case StatusCode::kUnreadable:
      return "unreadable";
    case StatusCode::kMalformed:
      return "malformed";
    case StatusCode::kNoSolution:
      return "no solution";
    case StatusCode::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

std::string Status::ToString() const {
  if (ok()) return StatusCodeName(code_);
  return std::string(StatusCodeName(code_)) + ": " + message_;
}

}  // namespace hpgo
