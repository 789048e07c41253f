// The parser of g2o files: what records refer to by number, once all are read.

#include <optional>

#include "hpgo/graph/compose_poses.h"
#include "hpgo/io/g2o_parser.h"

namespace hpgo {

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

template class G2oParser<SE2>;
template class G2oParser<SE3>;

}  // namespace hpgo
