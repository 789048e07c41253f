#include "hpgo/io/g2o_writer.h"

#include <algorithm>
#include <map>
#include <unordered_set>
#include <utility>

#include "ceres_costs/finite.h"
#include "hpgo/io/g2o_formatter.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/line_fields.h"
#include "hpgo/io/output_file.h"

namespace hpgo {
namespace {

// What the lines are made from. The file around a graph may be an empty one.
template <typename G>
struct Source {
  const PoseGraph<G>& graph;
  const GraphFile<G>& file;
};

std::string NodeName(NodeId id) { return "node " + std::to_string(id); }

template <typename G>
std::string EdgeName(const PoseGraph<G>& graph, const GraphEdge<G>& edge) {
  return "edge " + std::to_string(graph.nodes()[edge.i].id) + " - " +
         std::to_string(graph.nodes()[edge.j].id);
}

Status Invalid(const std::string& what) { return Status(StatusCode::kInvalidArgument, what); }

// What a reader would reject.
template <typename G>
Status CheckWritable(const PoseGraph<G>& graph) {
  const auto has_pose = [](const GraphNode<G>& node) { return node.has_pose; };
  const auto& nodes = graph.nodes();
  const bool any_pose = std::any_of(nodes.begin(), nodes.end(), has_pose);
  for (const GraphNode<G>& node : nodes) {
    if (any_pose && !node.has_pose) return Invalid(NodeName(node.id) + " has no pose");
    if (!IsFinite(node.pose)) return Invalid(NodeName(node.id) + ": its pose is not finite");
  }
  for (const GraphEdge<G>& edge : graph.edges()) {
    if (IsFinite(edge.measurement) && edge.information.allFinite()) continue;
    return Invalid(EdgeName(graph, edge) + " is not finite");
  }
  for (const GraphPrior<G>& prior : graph.priors()) {
    const std::string name = "prior at " + NodeName(nodes[prior.node].id);
    if (!IsFinite(prior.measurement) || !IsFinite(prior.offset) || !prior.information.allFinite()) {
      return Invalid(name + " is not finite");
    }
    if (G::kDim == 2 && !SamePose(prior.offset, G())) {
      return Invalid(name + " has an offset, which a 2D file cannot hold");
    }
  }
  return Status::Ok();
}

// How each prior is written, and the parameters that this takes beyond those of the file.
template <typename G>
struct PriorPlan {
  std::vector<PriorSyntax> syntax;
  std::vector<OffsetParameter<G>> added;
};

template <typename G>
PriorPlan<G> PlanPriors(const Source<G>& source) {
  const auto& priors = source.graph.priors();
  PriorPlan<G> plan;
  std::map<std::int64_t, G> known;
  for (const OffsetParameter<G>& offset : source.file.offsets) known[offset.id] = offset.pose;
  for (std::size_t k = 0; k < priors.size(); ++k) {
    const bool from_file = k < source.file.prior_syntax.size();
    PriorSyntax syntax = from_file ? source.file.prior_syntax[k] : PriorSyntax();
    const bool position_only = IsPositionOnly(priors[k]);
    syntax.position_only = from_file ? syntax.position_only && position_only : position_only;
    if (G::kDim == 3) {
      const G& offset = priors[k].offset;
      auto it = known.find(syntax.parameter);
      // A parameter that the file lacked stood for the identity, and does so again.
      const bool as_read = from_file && it == known.end() && SamePose(offset, G());
      if (!as_read && (it == known.end() || !SamePose(it->second, offset))) {
        it = std::find_if(known.begin(), known.end(),
                          [&](const auto& entry) { return SamePose(entry.second, offset); });
        if (it == known.end()) {
          const std::int64_t id = known.empty() ? 0 : known.rbegin()->first + 1;
          it = known.emplace(id, offset).first;
          plan.added.push_back({id, offset});
        }
        syntax.parameter = it->first;
      }
    }
    plan.syntax.push_back(syntax);
  }
  return plan;
}

template <typename G>
class G2oFileWriter {
 public:
  // To `text`, which goes to `out` whenever it is large, unless `out` is null.
  G2oFileWriter(const Source<G>& source, const WriteOptions& options, std::string* text,
                OutputFile* out)
      : graph_(source.graph),
        file_(source.file),
        text_(text),
        out_(out),
        plan_(PlanPriors(source)) {
    std::vector<bool> has_line(graph_.nodes().size(), false);
    for (const RecordRun& run : file_.order) {
      if (run.kind != RecordKind::kVertex) continue;
      std::fill_n(has_line.begin() + run.first, run.count, true);
    }
    for (std::size_t k = 0; k < has_line.size(); ++k) {
      if (!has_line[k]) added_nodes_.push_back(static_cast<int>(k));
    }
    if (!options.write_fixed) return;
    std::unordered_set<NodeId> named;
    for (const std::vector<NodeId>& ids : file_.fix) named.insert(ids.begin(), ids.end());
    for (const GraphNode<G>& node : graph_.nodes()) {
      if (node.fixed && named.count(node.id) == 0) added_fix_.push_back(node.id);
    }
  }

  void Write() {
    bool added = false;
    for (const RecordRun& run : file_.order) {
      // Comments at the top stay there.
      if (!added && run.kind != RecordKind::kVerbatim) {
        WriteAddedFirst();
        added = true;
      }
      for (int k = run.first; k < run.first + run.count; ++k) WriteRecord(run.kind, k);
    }
    if (!added) WriteAddedFirst();
    for (const NodeId id : added_fix_) WriteFix({id});
    const int edges = static_cast<int>(graph_.edges().size());
    for (int k = edges_written_; k < edges; ++k) WriteRecord(RecordKind::kEdge, k);
    const int priors = static_cast<int>(graph_.priors().size());
    for (int k = priors_written_; k < priors; ++k) WriteRecord(RecordKind::kPrior, k);
  }

 private:
  void WriteAddedFirst() {
    for (const OffsetParameter<G>& offset : plan_.added) AppendOffset(offset, text_);
    for (const int node : added_nodes_) WriteRecord(RecordKind::kVertex, node);
  }

  void WriteRecord(RecordKind kind, int k) {
    const auto& nodes = graph_.nodes();
    switch (kind) {
      case RecordKind::kVertex:
        if (nodes[k].has_pose) AppendVertex(nodes[k], text_);
        break;
      case RecordKind::kEdge: {
        const GraphEdge<G>& edge = graph_.edges()[k];
        AppendEdge(nodes[edge.i].id, nodes[edge.j].id, edge, text_);
        edges_written_ = k + 1;
        break;
      }
      case RecordKind::kPrior: {
        const GraphPrior<G>& prior = graph_.priors()[k];
        AppendPrior(nodes[prior.node].id, prior, plan_.syntax[k], text_);
        priors_written_ = k + 1;
        break;
      }
      case RecordKind::kFix:
        WriteFix(file_.fix[k]);
        break;
      case RecordKind::kOffset:
        AppendOffset(file_.offsets[k], text_);
        break;
      case RecordKind::kMerged: {
        const std::optional<int> node = graph_.Find(file_.merged[k].into);
        if (!node || !nodes[*node].has_pose) break;
        GraphNode<G> named = nodes[*node];
        named.id = file_.merged[k].id;
        AppendVertex(named, text_);
        break;
      }
      case RecordKind::kVerbatim:
        // A reader would take its first bytes for the file's mark.
        if (at_begin_ && HasFileMark(file_.verbatim[k])) *text_ += '\n';
        *text_ += file_.verbatim[k] + "\n";
        break;
    }
    at_begin_ = false;
    if (out_ != nullptr) out_->FlushIfLarge();
  }

  // Without the nodes that have been set free since. Those of landmarks stay.
  void WriteFix(const std::vector<NodeId>& ids) {
    std::string line;
    for (const NodeId id : ids) {
      const std::optional<int> node = graph_.Find(id);
      if (node && !graph_.nodes()[*node].fixed) continue;
      line += ' ';
      AppendNumber(id, &line);
    }
    if (!line.empty()) *text_ += "FIX" + line + "\n";
  }

  const PoseGraph<G>& graph_;
  const GraphFile<G>& file_;
  std::string* const text_;
  OutputFile* const out_;
  const PriorPlan<G> plan_;
  std::vector<int> added_nodes_;
  std::vector<NodeId> added_fix_;
  bool at_begin_ = true;
  int edges_written_ = 0, priors_written_ = 0;
};

template <typename G>
Status WriteSource(const Source<G>& source, const std::string& path, const WriteOptions& options) {
  const Status writable = CheckWritable(source.graph);
  if (!writable.ok()) return writable;
  OutputFile out(path);
  G2oFileWriter<G>(source, options, out.buffer(), &out).Write();
  return out.Commit();
}

}  // namespace

template <typename G>
Status WriteG2o(const GraphFile<G>& file, const std::string& path, const WriteOptions& options) {
  return WriteSource<G>({file.graph, file}, path, options);
}

template <typename G>
Status FormatG2o(const GraphFile<G>& file, const WriteOptions& options, std::string* text) {
  const Status writable = CheckWritable(file.graph);
  if (writable.ok()) G2oFileWriter<G>({file.graph, file}, options, text, nullptr).Write();
  return writable;
}

Status FormatG2o(const AnyGraphFile& file, const WriteOptions& options, std::string* text) {
  return std::visit([&](const auto& f) { return FormatG2o(f, options, text); }, file);
}

template <typename G>
Status WriteG2o(const PoseGraph<G>& graph, const std::string& path, const WriteOptions& options) {
  const GraphFile<G> no_file;
  return WriteSource<G>({graph, no_file}, path, options);
}

Status WriteG2o(const AnyGraphFile& file, const std::string& path, const WriteOptions& options) {
  return std::visit([&](const auto& f) { return WriteG2o(f, path, options); }, file);
}

template Status WriteG2o(const GraphFile<SE2>&, const std::string&, const WriteOptions&);
template Status WriteG2o(const GraphFile<SE3>&, const std::string&, const WriteOptions&);
template Status FormatG2o(const GraphFile<SE2>&, const WriteOptions&, std::string*);
template Status FormatG2o(const GraphFile<SE3>&, const WriteOptions&, std::string*);
template Status WriteG2o(const PoseGraph<SE2>&, const std::string&, const WriteOptions&);
template Status WriteG2o(const PoseGraph<SE3>&, const std::string&, const WriteOptions&);

}  // namespace hpgo
