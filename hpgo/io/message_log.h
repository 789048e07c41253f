// Collects the warnings and errors about the lines of a file.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hpgo/graph/status.h"
#include "hpgo/io/read_report.h"

namespace hpgo {

// Warnings of one kind are listed up to a limit, then counted.
enum class WarningKind {
  kUnknownTag,
  kNotOptimized,
  kConverted,
  kDuplicate,
  kQuaternion,
  kProjected,
  kIdentity,
  kNoOffset,
  kCreated,
  kCount,
};

class MessageLog {
 public:
  MessageLog(std::string file, const ReadOptions& options)
      : file_(std::move(file)), options_(options) {}

  // Line 0 stands for the file as a whole.
  void Error(std::int64_t line, const std::string& what, std::string_view offending);
  void Warn(WarningKind kind, std::int64_t line, const std::string& what,
            std::string_view offending);
  // A warning, or an error under ReadOptions::strict.
  void Oddity(WarningKind kind, std::int64_t line, const std::string& what,
              std::string_view offending);

  // True after an error, unless all are to be collected.
  bool stopped() const { return !errors_.empty() && !options_.collect_all_problems; }
  bool ok() const { return errors_.empty(); }

  // Moves the messages into the report; kMalformed with the first error by line, if there is one.
  Status Finish(ReadReport* report);

 private:
  struct Entry {
    std::int64_t line;
    std::string text;
  };
  std::string Format(std::int64_t line, const std::string& what, std::string_view offending) const;

  std::string file_;
  ReadOptions options_;
  std::vector<Entry> warnings_, errors_;
  std::array<std::int64_t, static_cast<std::size_t>(WarningKind::kCount)> counts_{};
};

}  // namespace hpgo
