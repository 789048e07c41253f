// Turns the text of a g2o or TORO file into a GraphFile of one dimension. Behind g2o_reader.h.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "hpgo/io/graph_file.h"
#include "hpgo/io/record_reader.h"
#include "hpgo/io/tag_census.h"

namespace hpgo {

// One pass over the lines; what they refer to by number (vertices, parameters) is resolved at the
// end, as it may stand anywhere in the file. Use an object once.
template <typename G>
class G2oParser {
 public:
  // `text` must outlive the parser. `file` is the name in messages.
  G2oParser(std::string_view text, const std::string& file, const ReadOptions& options);

  // On an error `out` is unchanged; the report is filled either way.
  Status Parse(GraphFile<G>* out, ReadReport* report);

 private:
  struct Place {
    std::int64_t number;  // of the line
    const char* text;     // where it begins
  };

  // g2o_parser.cc
  void ReserveForText();
  void ReadEquivalences();
  NodeId FindSmallest(NodeId id);
  // The id of the node that is called `id`.
  NodeId NodeCalled(NodeId id) const;
  void ParseLine();
  void ParseRecord(LineFields* fields, std::string_view name);
  std::string_view LineAt(const char* begin) const;

  // g2o_parser_records.cc
  void ParseVertex(LineFields* fields);
  void ParseMergedVertex(const GraphNode<G>& node);
  void ParseEdge();
  void ParsePrior();
  void ParseOffset();
  void ParseFix(LineFields* fields);
  void KeepVerbatim();
  // The index of the node; adds it without a pose where no line has named it so far.
  int Mention(NodeId id);

  // g2o_parser_resolve.cc
  void ResolveOffsets();
  void ResolveFixed();
  void ResolveMissing();

  const std::string_view text_;
  const ReadOptions options_;
  MessageLog log_;
  ReadReport counts_;
  RecordReader<G> record_;
  TagCensus tags_;
  GraphFile<G> file_;

  Place place_{0, nullptr};
  std::string_view line_;
  std::int64_t vertices_ = 0;
  std::vector<Place> node_places_;  // where each node is first named, or given
  std::vector<Place> prior_places_;
  std::vector<Place> fix_places_;
  std::unordered_map<std::int64_t, int> offset_index_;
  std::unordered_set<NodeId> other_vertices_;  // of landmarks and unknown tags
  bool has_equivalences_ = false;
  std::unordered_map<NodeId, NodeId> equivalent_;  // to the smallest id, which is the node's
  std::unordered_map<NodeId, GraphNode<G>> merged_poses_;  // the first for each node
};

extern template class G2oParser<SE2>;
extern template class G2oParser<SE3>;

}  // namespace hpgo
