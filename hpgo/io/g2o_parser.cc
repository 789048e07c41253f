// The parser of g2o files: the text, line by line, and the nodes with two names.

#include "hpgo/io/g2o_parser.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace hpgo {
namespace {

// Where the line after the one at `begin` starts, or `end`.
const char* NextLine(const char* begin, const char* end) {
  const void* found = std::memchr(begin, '\n', static_cast<std::size_t>(end - begin));
  return found ? static_cast<const char*>(found) + 1 : end;
}

// Without the end of the line, LF or CR LF. Two CR are none: a line that is kept keeps them, or one
// would be lost at each rewrite.
std::string_view LineBetween(const char* begin, const char* next) {
  std::string_view line(begin, static_cast<std::size_t>(next - begin));
  if (!line.empty() && line.back() == '\n') line.remove_suffix(1);
  const bool carriage_return = !line.empty() && line.back() == '\r';
  if (carriage_return && (line.size() < 2 || line[line.size() - 2] != '\r')) line.remove_suffix(1);
  return line;
}

}  // namespace

template <typename G>
G2oParser<G>::G2oParser(std::string_view text, const std::string& file, const ReadOptions& options)
    : text_(text), options_(options), log_(file, options), record_(options, &log_, &counts_) {}

template <typename G>
Status G2oParser<G>::Parse(GraphFile<G>* out, ReadReport* report) {
  ReserveForText();
  if (has_equivalences_) ReadEquivalences();
  const char* const end = text_.data() + text_.size();
  for (const char* next = text_.data(); next != end && !log_.stopped();) {
    place_ = {place_.number + 1, next};
    next = NextLine(next, end);
    line_ = LineBetween(place_.text, next);
    ParseLine();
  }
  if (!log_.stopped()) {
    ResolveOffsets();
    ResolveFixed();
    ResolveMissing();
  }
  tags_.Report(options_.strict, &log_, &counts_);
  counts_.bytes = static_cast<std::int64_t>(text_.size());
  counts_.lines = place_.number;
  const Status status = log_.Finish(&counts_);
  if (status.ok()) *out = std::move(file_);
  *report = std::move(counts_);
  return status;
}

// One look at the first letter of each line is far cheaper than growing the arrays.
template <typename G>
void G2oParser<G>::ReserveForText() {
  std::size_t vertices = 0, edges = 0;
  const char* const end = text_.data() + text_.size();
  for (const char* next = text_.data(); next != end; next = NextLine(next, end)) {
    vertices += *next == 'V';
    edges += *next == 'E';
    const char* tag = next;
    while (tag != end && (*tag == ' ' || (*tag >= '\t' && *tag <= '\r'))) ++tag;
    has_equivalences_ |= end - tag >= 2 && tag[0] == 'E' && tag[1] == 'Q';
  }
  file_.graph.Reserve(vertices, edges);
  node_places_.reserve(vertices);
}

// Ahead of all else: the lines may stand anywhere. What is wrong with them is said later.
template <typename G>
void G2oParser<G>::ReadEquivalences() {
  const char* const end = text_.data() + text_.size();
  for (const char* begin = text_.data(); begin != end;) {
    const char* const next = NextLine(begin, end);
    LineFields fields(LineBetween(begin, next));
    begin = next;
    NodeId a = 0, b = 0;
    if (FindRecordTag(fields.Word()).type != RecordType::kEquivalence) continue;
    if (!fields.Read(&a) || !fields.Read(&b)) continue;
    a = FindSmallest(a);
    b = FindSmallest(b);
    if (a != b) equivalent_[std::max(a, b)] = std::min(a, b);
  }
  // One step from each name to its node.
  for (auto& [id, node] : equivalent_) node = FindSmallest(node);
}

// Shortens the way for the next time.
template <typename G>
NodeId G2oParser<G>::FindSmallest(NodeId id) {
  auto it = equivalent_.find(id);
  while (it != equivalent_.end()) {
    const auto next = equivalent_.find(it->second);
    id = it->second;
    if (next != equivalent_.end()) it->second = next->second;
    it = next;
  }
  return id;
}

template <typename G>
NodeId G2oParser<G>::NodeCalled(NodeId id) const {
  if (!has_equivalences_) return id;
  const auto found = equivalent_.find(id);
  return found == equivalent_.end() ? id : found->second;
}

template <typename G>
void G2oParser<G>::ParseLine() {
  LineFields fields(line_);
  const std::string_view name = fields.Word();
  if (!name.empty()) {
    record_.Begin(place_.number, line_, &tags_.Count(name, place_.number));
    ParseRecord(&fields, name);
  } else if (line_.find('#') != std::string_view::npos) {
    ++counts_.comments;
    KeepVerbatim();
  }
}

template <typename G>
void G2oParser<G>::ParseRecord(LineFields* fields, std::string_view name) {
  const RecordTag& tag = record_.tag();
  if (tag.dimension != 0 && tag.dimension != G::kDim) {
    record_.Fail(tag.dimension == 3 ? "3D record in a 2D file" : "2D record in a 3D file", line_);
    return;
  }
  switch (tag.type) {
    case RecordType::kVertex:
      ParseVertex(fields);
      break;
    case RecordType::kEdge:
      if (record_.ReadNumbers(fields)) ParseEdge();
      break;
    case RecordType::kPrior:
      if (record_.ReadNumbers(fields)) ParsePrior();
      break;
    case RecordType::kOffset:
      if (record_.ReadNumbers(fields)) ParseOffset();
      break;
    case RecordType::kFix:
      ParseFix(fields);
      break;
    case RecordType::kEquivalence:
      if (record_.ReadNumbers(fields)) KeepVerbatim();
      break;
    case RecordType::kLandmark:
    case RecordType::kUnknown: {
      ++(tag.type == RecordType::kLandmark ? counts_.landmarks : counts_.unknown);
      std::int64_t id = 0;
      if (name.substr(0, 6) == "VERTEX" && fields->Read(&id)) other_vertices_.insert(id);
      KeepVerbatim();
      if (options_.strict && tags_.was_first()) {
        record_.Fail(
            tag.type == RecordType::kUnknown ? "unknown tag" : "landmarks are not optimized", name);
      }
      break;
    }
  }
}

template <typename G>
std::string_view G2oParser<G>::LineAt(const char* begin) const {
  return LineBetween(begin, NextLine(begin, text_.data() + text_.size()));
}

template class G2oParser<SE2>;
template class G2oParser<SE3>;

}  // namespace hpgo
