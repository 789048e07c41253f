#include "hpgo/io/message_log.h"

#include <algorithm>

#include "hpgo/io/line_fields.h"

namespace hpgo {
namespace {

constexpr std::int64_t kListedOfAKind = 5;

const char* Summary(WarningKind kind) {
  switch (kind) {
    case WarningKind::kUnknownTag:
      return "unknown tags";
    case WarningKind::kNotOptimized:
      return "tags that are not optimized";
    case WarningKind::kConverted:
      return "conversions";
    case WarningKind::kDuplicate:
      return "vertices given twice";
    case WarningKind::kQuaternion:
      return "quaternions normalized";
    case WarningKind::kProjected:
      return "information matrices projected";
    case WarningKind::kIdentity:
      return "informations taken as the identity";
    case WarningKind::kNoOffset:
      return "priors without their parameter";
    case WarningKind::kCreated:
      return "missing vertices composed";
    case WarningKind::kCount:
      break;
  }
  return "";
}

}  // namespace

std::string MessageLog::Format(std::int64_t line, const std::string& what,
                               std::string_view offending) const {
  std::string text = file_;
  if (line > 0) text += ":" + std::to_string(line);
  text += ": " + what;
  if (!offending.empty()) text += ": " + Quoted(offending);
  return text;
}

void MessageLog::Error(std::int64_t line, const std::string& what, std::string_view offending) {
  errors_.push_back({line, Format(line, what, offending)});
}

void MessageLog::Warn(WarningKind kind, std::int64_t line, const std::string& what,
                      std::string_view offending) {
  const std::int64_t count = ++counts_[static_cast<std::size_t>(kind)];
  if (count > kListedOfAKind && !options_.collect_all_problems) return;
  warnings_.push_back({line, Format(line, what, offending)});
}

void MessageLog::Oddity(WarningKind kind, std::int64_t line, const std::string& what,
                        std::string_view offending) {
  if (options_.strict) {
    Error(line, what, offending);
  } else {
    Warn(kind, line, what, offending);
  }
}

Status MessageLog::Finish(ReadReport* report) {
  const auto by_line = [](const Entry& a, const Entry& b) { return a.line < b.line; };
  std::stable_sort(warnings_.begin(), warnings_.end(), by_line);
  std::stable_sort(errors_.begin(), errors_.end(), by_line);
  for (Entry& warning : warnings_) report->warnings.push_back(std::move(warning.text));
  for (std::size_t kind = 0; kind < counts_.size(); ++kind) {
    const std::int64_t others = counts_[kind] - kListedOfAKind;
    if (others <= 0 || options_.collect_all_problems) continue;
    report->warnings.push_back(file_ + ": " + std::to_string(others) +
                               " more: " + Summary(static_cast<WarningKind>(kind)));
  }
  if (options_.collect_all_problems) {
    for (const Entry& error : errors_) report->problems.push_back(error.text);
  }
  return ok() ? Status::Ok() : Status(StatusCode::kMalformed, errors_.front().text);
}

}  // namespace hpgo
