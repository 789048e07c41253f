#include "hpgo/io/g2o_parser.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "hpgo/graph/compose_poses.h"

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

template <typename G>
bool SameBits(const G& a, const G& b) {
  return std::memcmp(a.data(), b.data(), G::kParams * sizeof(double)) == 0;
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
void G2oParser<G>::ParseVertex(LineFields* fields) {
  ++vertices_;
  GraphNode<G> node;
  const bool ok = record_.ReadNumbers(fields) && record_.TakePose(&node.pose);
  // After an error the node exists all the same, or each of its edges would be one more.
  if (record_.ids_read() == 0) return;
  node.id = record_.id(0);
  if (NodeCalled(node.id) != node.id) {
    if (ok) ParseMergedVertex(node);
    return;
  }
  const std::optional<int> found = file_.graph.Find(node.id);
  int index = 0;
  if (!found) {
    index = *file_.graph.AddNode(node);
    node_places_.push_back(place_);
  } else if (!file_.graph.nodes()[*found].has_pose) {
    index = *found;
    file_.graph.node(index) = node;
    node_places_[index] = place_;
  } else {
    if (!ok) return;
    const std::string what = "vertex " + std::to_string(node.id) + " was given in line " +
                             std::to_string(node_places_[*found].number);
    if (!SameBits(node.pose, file_.graph.nodes()[*found].pose)) {
      record_.Fail(what + " with another pose", line_);
    } else {
      ++counts_.duplicate_vertices;
      record_.Oddity(WarningKind::kDuplicate, what + " with the same pose", line_);
    }
    return;
  }
  file_.AddRecord(RecordKind::kVertex, index);
}

// Its pose counts where the node has none of its own.
template <typename G>
void G2oParser<G>::ParseMergedVertex(const GraphNode<G>& node) {
  const NodeId into = NodeCalled(node.id);
  ++counts_.merged_nodes;
  merged_poses_.emplace(into, node);
  Mention(into);
  file_.AddRecord(RecordKind::kMerged, static_cast<int>(file_.merged.size()));
  file_.merged.push_back({node.id, into});
}

template <typename G>
void G2oParser<G>::ParseEdge() {
  if (record_.id(0) == record_.id(1)) {
    record_.Fail("edge from node " + std::to_string(record_.id(0)) + " to itself", line_);
    return;
  }
  if (NodeCalled(record_.id(0)) == NodeCalled(record_.id(1))) {
    const std::string ids = std::to_string(record_.id(0)) + " and " + std::to_string(record_.id(1));
    record_.Oddity(WarningKind::kNotOptimized,
                   "nodes " + ids + " are one node by EQUIV, the edge is kept as it is", line_);
    KeepVerbatim();
    return;
  }
  GraphEdge<G> edge;
  edge.i = Mention(NodeCalled(record_.id(0)));
  edge.j = Mention(NodeCalled(record_.id(1)));
  if (!record_.TakePose(&edge.measurement) || !record_.TakeInformation(&edge.information)) return;
  tags_.TookEdge();
  file_.AddRecord(RecordKind::kEdge, static_cast<int>(file_.graph.edges().size()));
  const Status added = file_.graph.AddEdge(edge);
  if (!added.ok()) record_.Fail(added.message(), line_);
}

template <typename G>
void G2oParser<G>::ParsePrior() {
  const RecordTag& tag = record_.tag();
  GraphPrior<G> prior;
  prior.node = Mention(NodeCalled(record_.id(0)));
  if (!record_.TakePose(&prior.measurement)) return;
  if (!record_.TakeInformation(&prior.information)) return;
  PriorSyntax syntax;
  syntax.position_only = tag.pose == G::kDim;
  if (tag.parameter >= 0) syntax.parameter = record_.id(tag.parameter);
  file_.AddRecord(RecordKind::kPrior, static_cast<int>(file_.graph.priors().size()));
  file_.prior_syntax.push_back(syntax);
  prior_places_.push_back(place_);
  const Status added = file_.graph.AddPrior(prior);
  if (!added.ok()) record_.Fail(added.message(), line_);
}

template <typename G>
void G2oParser<G>::ParseOffset() {
  OffsetParameter<G> offset;
  offset.id = record_.id(0);
  if (!record_.TakePose(&offset.pose)) return;
  const int index = static_cast<int>(file_.offsets.size());
  const auto [it, added] = offset_index_.emplace(offset.id, index);
  if (!added && !SameBits(offset.pose, file_.offsets[it->second].pose)) {
    record_.Fail("parameter " + std::to_string(offset.id) + " was given with another pose", line_);
    return;
  }
  file_.AddRecord(RecordKind::kOffset, index);
  file_.offsets.push_back(offset);
}

template <typename G>
void G2oParser<G>::ParseFix(LineFields* fields) {
  std::vector<NodeId> ids;
  while (!fields->AtEnd()) {
    NodeId id = 0;
    if (!fields->Read(&id)) {
      record_.Fail(std::string("FIX: ") + fields->what_failed(), fields->failed_field());
      return;
    }
    ids.push_back(id);
  }
  if (ids.empty()) {
    record_.Fail("FIX names no node", line_);
    return;
  }
  file_.AddRecord(RecordKind::kFix, static_cast<int>(file_.fix.size()));
  file_.fix.push_back(std::move(ids));
  fix_places_.push_back(place_);
}

template <typename G>
void G2oParser<G>::KeepVerbatim() {
  file_.AddRecord(RecordKind::kVerbatim, static_cast<int>(file_.verbatim.size()));
  file_.verbatim.emplace_back(line_);
}

template <typename G>
int G2oParser<G>::Mention(NodeId id) {
  const std::optional<int> found = file_.graph.Find(id);
  if (found) return *found;
  GraphNode<G> node;
  node.id = id;
  node.has_pose = false;
  node_places_.push_back(place_);
  return *file_.graph.AddNode(node);
}

template <typename G>
void G2oParser<G>::ResolveOffsets() {
  if (G::kDim == 2) return;  // the priors of the plane name no parameter
  for (std::size_t k = 0; k < file_.graph.priors().size(); ++k) {
    const std::int64_t id = file_.prior_syntax[k].parameter;
    const auto it = offset_index_.find(id);
    if (it != offset_index_.end()) {
      file_.graph.prior(static_cast<int>(k)).offset = file_.offsets[it->second].pose;
      continue;
    }
    ++counts_.priors_without_offset;
    log_.Oddity(WarningKind::kNoOffset, prior_places_[k].number,
                "no PARAMS_SE3OFFSET " + std::to_string(id) + ", the identity is taken",
                LineAt(prior_places_[k].text));
  }
}

template <typename G>
void G2oParser<G>::ResolveFixed() {
  for (std::size_t k = 0; k < file_.fix.size(); ++k) {
    for (const NodeId id : file_.fix[k]) {
      const std::optional<int> found = file_.graph.Find(NodeCalled(id));
      if (found) {
        file_.graph.node(*found).fixed = true;
      } else if (other_vertices_.count(id) == 0) {
        log_.Error(fix_places_[k].number,
                   "FIX of node " + std::to_string(id) + ", which is not there",
                   LineAt(fix_places_[k].text));
      }
    }
  }
}

template <typename G>
void G2oParser<G>::ResolveMissing() {
  const std::size_t size = file_.graph.nodes().size();
  if (vertices_ == 0) {
    counts_.edges_only = size > 0;
    if (size == 0 && log_.ok()) {
      const bool others = counts_.unknown + counts_.landmarks > 0;
      log_.Error(0,
                 std::string("holds no vertex and no edge") +
                     (others ? " with a tag that is read; hpgo check --help lists those" : ""),
                 {});
    }
    return;
  }
  for (std::size_t k = 0; k < size; ++k) {
    GraphNode<G>& node = file_.graph.node(static_cast<int>(k));
    if (node.has_pose) continue;
    if (const auto merged = merged_poses_.find(node.id); merged != merged_poses_.end()) {
      node.pose = merged->second.pose;
      node.has_pose = true;
      continue;
    }
    const std::string what = "no vertex " + std::to_string(node.id);
    const std::string_view line = LineAt(node_places_[k].text);
    if (options_.create_missing) {
      ++counts_.created_nodes;
      log_.Warn(WarningKind::kCreated, node_places_[k].number,
                what + ", its pose is composed from the edges", line);
    } else {
      log_.Error(node_places_[k].number, what, line);
    }
  }
  if (counts_.created_nodes > 0) ComposeMissingPoses(&file_.graph);
}

template <typename G>
std::string_view G2oParser<G>::LineAt(const char* begin) const {
  return LineBetween(begin, NextLine(begin, text_.data() + text_.size()));
}

template class G2oParser<SE2>;
template class G2oParser<SE3>;

}  // namespace hpgo
