// The parser of g2o files: what each kind of record says.

#include <cstring>
#include <optional>
#include <utility>

#include "hpgo/io/g2o_parser.h"

namespace hpgo {
namespace {

template <typename G>
bool SameBits(const G& a, const G& b) {
  return std::memcmp(a.data(), b.data(), G::kParams * sizeof(double)) == 0;
}

}  // namespace

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

template class G2oParser<SE2>;
template class G2oParser<SE3>;

}  // namespace hpgo
