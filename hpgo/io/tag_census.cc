#include "hpgo/io/tag_census.h"

namespace hpgo {
namespace {

std::string LineCount(std::int64_t count) {
  return std::to_string(count) + (count == 1 ? " line" : " lines");
}

}  // namespace

const RecordTag& TagCensus::Count(std::string_view name, std::int64_t line) {
  if (last_ == lines_.end() || last_->first != name) {
    last_ = lines_.find(name);
    if (last_ == lines_.end()) {
      last_ = lines_.emplace(std::string(name), Lines{&FindRecordTag(name), line, 0, 0}).first;
    }
  }
  ++last_->second.count;
  return *last_->second.tag;
}

void TagCensus::Report(bool strict, MessageLog* log, ReadReport* report) const {
  for (const auto& [name, lines] : lines_) {
    report->tags.emplace(name, lines.count);
    const std::string count = LineCount(lines.count);
    const RecordType type = lines.tag->type;
    if (type == RecordType::kUnknown && !strict) {
      log->Warn(WarningKind::kUnknownTag, lines.first,
                "unknown tag, " + count + " kept as they are", name);
    } else if (type == RecordType::kLandmark && !strict) {
      log->Warn(WarningKind::kNotOptimized, lines.first,
                "landmarks are not optimized, " + count + " kept as they are", name);
    } else if (type == RecordType::kEquivalence) {
      log->Warn(WarningKind::kConverted, lines.first, "the nodes it names are one node, " + count,
                name);
    } else if (lines.edges > 0 && lines.tag->form == InformationForm::kRoot) {
      log->Warn(WarningKind::kConverted, lines.first,
                "its numbers are taken as the square root of the information, as iSAM writes them, "
                "in " +
                    LineCount(lines.edges),
                name);
    } else if (lines.edges > 0 && lines.tag->pose == 6) {
      log->Warn(WarningKind::kConverted, lines.first,
                "information of Euler angles turned into that of the quaternion in " +
                    LineCount(lines.edges),
                name);
    }
  }
}

}  // namespace hpgo
