// A pose graph together with what else stood in its file, so that writing it again loses nothing.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// PARAMS_SE3OFFSET, PARAMS_SE2OFFSET: the pose of a sensor on the robot, by a number.
template <typename G>
struct OffsetParameter {
  std::int64_t id = 0;
  G pose;  // T_node_sensor
};

// How a prior stood in its file.
struct PriorSyntax {
  bool position_only = false;  // EDGE_PRIOR_SE2_XY, EDGE_SE3_XYZ_PRIOR
  std::int64_t parameter = 0;  // of the PARAMS_SE3OFFSET line it names; none in 2D
};

// A further name of a node, by TORO's EQUIV. What the file says of it is said of the node.
struct MergedNode {
  NodeId id = 0;
  NodeId into = 0;  // the node of the graph
};

enum class RecordKind : std::uint8_t { kVertex, kEdge, kPrior, kFix, kOffset, kMerged, kVerbatim };

// `count` lines of one kind in a row, with consecutive indices into the array that holds them.
struct RecordRun {
  RecordKind kind;
  int first;
  int count;
};

// After reading, either every node of `graph` has a pose, or none has: the file holds edges only.
// Nodes stand in the order in which vertices or edges first name them.
template <typename G>
struct GraphFile {
  PoseGraph<G> graph;
  std::vector<PriorSyntax> prior_syntax;    // of the first priors of `graph`
  std::vector<OffsetParameter<G>> offsets;  // in file order
  std::vector<std::vector<NodeId>> fix;     // the ids of each FIX line
  std::vector<MergedNode> merged;           // of the vertex lines with such a name
  std::vector<std::string> verbatim;        // comments, landmarks, unknown tags
  // The order of the lines. May leave out nodes, edges and priors that were added since: the writer
  // puts such nodes first and the others last.
  std::vector<RecordRun> order;

  // Appends to `order`.
  void AddRecord(RecordKind kind, int index);
};

using AnyGraphFile = std::variant<GraphFile<SE2>, GraphFile<SE3>>;

extern template struct GraphFile<SE2>;
extern template struct GraphFile<SE3>;

}  // namespace hpgo
