#include "hpgo/io/g2o_formatter.h"

#include <cstring>
#include <string_view>
#include <type_traits>

#include "hpgo/io/line_fields.h"

namespace hpgo {
namespace {

template <typename G>
constexpr bool kPlanar = std::is_same_v<G, SE2>;

void AppendNumbers(const double* values, int count, std::string* text) {
  for (int k = 0; k < count; ++k) {
    *text += ' ';
    AppendNumber(values[k], text);
  }
}

void AppendId(std::int64_t id, std::string* text) {
  *text += ' ';
  AppendNumber(id, text);
}

// The upper triangle of the leading block.
template <typename Matrix>
void AppendInformation(const Matrix& information, int size, std::string* text) {
  for (int r = 0; r < size; ++r) {
    for (int c = r; c < size; ++c) AppendNumbers(&information(r, c), 1, text);
  }
}

}  // namespace

template <typename G>
bool SamePose(const G& a, const G& b) {
  return std::memcmp(a.data(), b.data(), G::kParams * sizeof(double)) == 0;
}

template <typename G>
void AppendVertex(const GraphNode<G>& node, std::string* text) {
  *text += kPlanar<G> ? "VERTEX_SE2" : "VERTEX_SE3:QUAT";
  AppendId(node.id, text);
  AppendNumbers(node.pose.data(), G::kParams, text);
  *text += '\n';
}

template <typename G>
void AppendEdge(NodeId i, NodeId j, const GraphEdge<G>& edge, std::string* text) {
  *text += kPlanar<G> ? "EDGE_SE2" : "EDGE_SE3:QUAT";
  AppendId(i, text);
  AppendId(j, text);
  AppendNumbers(edge.measurement.data(), G::kParams, text);
  AppendInformation(edge.information, G::kDof, text);
  *text += '\n';
}

template <typename G>
void AppendOffset(const OffsetParameter<G>& offset, std::string* text) {
  *text += kPlanar<G> ? "PARAMS_SE2OFFSET" : "PARAMS_SE3OFFSET";
  AppendId(offset.id, text);
  AppendNumbers(offset.pose.data(), G::kParams, text);
  *text += '\n';
}

template <typename G>
void AppendPrior(NodeId node, const GraphPrior<G>& prior, const PriorSyntax& syntax,
                 std::string* text) {
  if (kPlanar<G>) {
    *text += syntax.position_only ? "EDGE_PRIOR_SE2_XY" : "EDGE_PRIOR_SE2";
  } else {
    *text += syntax.position_only ? "EDGE_SE3_XYZ_PRIOR" : "EDGE_SE3_PRIOR";
  }
  AppendId(node, text);
  if (!kPlanar<G>) AppendId(syntax.parameter, text);
  AppendNumbers(prior.measurement.data(), syntax.position_only ? G::kDim : G::kParams, text);
  AppendInformation(prior.information, syntax.position_only ? G::kDim : G::kDof, text);
  *text += '\n';
}

template <typename G>
bool IsPositionOnly(const GraphPrior<G>& prior) {
  G position;
  position.translation() = prior.measurement.translation();
  return SamePose(position, prior.measurement) &&
         prior.information.template rightCols<G::kRotationDof>().isZero(0) &&
         prior.information.template bottomRows<G::kRotationDof>().isZero(0);
}

template void AppendVertex(const GraphNode<SE2>&, std::string*);
template void AppendVertex(const GraphNode<SE3>&, std::string*);
template void AppendEdge(NodeId, NodeId, const GraphEdge<SE2>&, std::string*);
template void AppendEdge(NodeId, NodeId, const GraphEdge<SE3>&, std::string*);
template void AppendOffset(const OffsetParameter<SE2>&, std::string*);
template void AppendOffset(const OffsetParameter<SE3>&, std::string*);
template void AppendPrior(NodeId, const GraphPrior<SE2>&, const PriorSyntax&, std::string*);
template void AppendPrior(NodeId, const GraphPrior<SE3>&, const PriorSyntax&, std::string*);
template bool IsPositionOnly(const GraphPrior<SE2>&);
template bool IsPositionOnly(const GraphPrior<SE3>&);
template bool SamePose(const SE2&, const SE2&);
template bool SamePose(const SE3&, const SE3&);

}  // namespace hpgo
