// The records of a pose graph as lines of a g2o file. Behind g2o_writer.h.
#pragma once

#include <string>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/io/graph_file.h"

namespace hpgo {

// Each call appends one line to `text`.
template <typename G>
void AppendVertex(const GraphNode<G>& node, std::string* text);
template <typename G>
void AppendEdge(NodeId i, NodeId j, const GraphEdge<G>& edge, std::string* text);
template <typename G>
void AppendOffset(const OffsetParameter<G>& offset, std::string* text);
template <typename G>
void AppendPrior(NodeId node, const GraphPrior<G>& prior, const PriorSyntax& syntax,
                 std::string* text);

// Whether a line for positions alone says all there is to say about `prior`.
template <typename G>
bool IsPositionOnly(const GraphPrior<G>& prior);

template <typename G>
bool SamePose(const G& a, const G& b);

}  // namespace hpgo
