#include "hpgo/update/far_closures.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hpgo/update/constants.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// In degrees.
template <typename G>
double Distance(const G& from, const G& to, double reach) {
  const typename G::Tangent d = to.Minus(from);
  return std::max(d.template tail<G::kRotationDof>().norm() / kTurnOfADegree,
                  d.template head<G::kDim>().norm() / reach);
}

// How far it is from a node of level 0 to the farthest of the nodes around it, without an edge; all
// that is `enough`, where it is.
template <typename G>
double Extent(Index node, Index without, int num_nodes, double enough, Hierarchy<G>* hierarchy) {
  Level<G>& level = hierarchy->mutable_level(0);
  const std::uint32_t seen = hierarchy->NewStamp();
  const G origin = hierarchy->WorldPose(0, node);
  double extent = 0;
  std::vector<Index> nodes = {node};
  level.nodes[node].stamp = seen;
  for (std::size_t k = 0; k < nodes.size() && extent < enough; ++k) {
    ForEachEdge(level, nodes[k], [&](Index e, Index other) {
      if (other == kNone || e == without || level.nodes[other].stamp == seen) return;
      if (static_cast<int>(nodes.size()) >= num_nodes) return;
      level.nodes[other].stamp = seen;
      nodes.push_back(other);
      extent =
          std::max(extent, origin.Between(hierarchy->WorldPose(0, other)).translation().norm());
    });
  }
  return extent;
}

// m of a degree, for an edge that has so far to go; infinite where that is no more than one.
template <typename G>
double Reach(Index edge, const typename G::Tangent& way, int num_nodes, CondensedGraph<G>* graph) {
  const double enough = way.template head<G::kDim>().norm() / kExtentOfADegree;
  double extent = enough;
  for (int side = 0; side < 2; ++side) {
    const Index end = graph->LevelNodeOf(graph->End(edge, side));
    extent = std::min(
        extent, Extent(end, graph->LevelEdgeOf(edge), num_nodes, extent, &graph->hierarchy()));
  }
  return extent < enough ? kExtentOfADegree * extent : std::numeric_limits<double>::infinity();
}

// A degree of the way from where it is; all of it where that is no more, or none is left.
template <typename G>
void PullADegree(Index e, const Pull& pull, CondensedGraph<G>* graph) {
  const G from = graph->RelativePose(e), measured = graph->FactorOf(e).term->measurement;
  const double degrees =
      std::min<double>(std::ceil(Distance(from, measured, pull.reach)), pull.left);
  if (degrees > 1) {
    graph->PullTowards(e, from.Plus(measured.Minus(from) / degrees), {pull.left - 1, pull.reach});
  } else {
    graph->EndPull(e);
  }
}

// Where an edge pulls to if it has as far to go as another one, in the world, or as far the other
// way: which end of the other is near which of its own is not known.
template <typename G>
G AsFarOnTheWay(Index edge, Index other, bool same_way, CondensedGraph<G>* graph) {
  const G X_edge = graph->WorldPose(graph->End(edge, 0));
  const G X_other = graph->WorldPose(graph->End(other, 0));
  const G& Z_other = graph->pulled().at(other).measured.measurement;
  const G left = X_other * graph->PullOf(other) * Z_other.Inverse() * X_other.Inverse();
  const G pull = X_edge.Inverse() * (same_way ? left : left.Inverse()) * X_edge *
                 graph->FactorOf(edge).term->measurement;
  return pull.Normalized();
}

// Begins where others are, if that is less than a degree from where it is.
template <typename G>
bool JoinOthers(Index e, const G& from, CondensedGraph<G>* graph) {
  G nearest;
  Pull pull;
  double distance = 1;
  for (const auto& [other, pulled] : graph->pulled()) {
    for (const bool same_way : {true, false}) {
      const G there = AsFarOnTheWay(e, other, same_way, graph);
      const double d = Distance(from, there, pulled.pull.reach);
      if (!(d < distance)) continue;
      distance = d;
      nearest = there;
      pull = pulled.pull;
    }
  }
  if (distance < 1) graph->PullTowards(e, nearest, pull);
  return distance < 1;
}

// All have all but come to where they pull.
template <typename G>
bool AreNear(CondensedGraph<G>* graph) {
  const auto is_near = [&](const auto& pulled) {
    const G from = graph->RelativePose(pulled.first), &to = graph->PullOf(pulled.first);
    return Distance(from, to, pulled.second.pull.reach) < kNearly;
  };
  return std::all_of(graph->pulled().begin(), graph->pulled().end(), is_near);
}

template <typename G>
std::vector<Index> PulledEdges(const CondensedGraph<G>& graph) {
  std::vector<Index> edges;
  for (const auto& [e, pulled] : graph.pulled()) edges.push_back(e);
  return edges;
}

}  // namespace

template <typename G>
std::vector<Index> FarClosures<G>::Begin(const std::vector<Index>& edges, int num_nodes,
                                         CondensedGraph<G>* graph) {
  const std::vector<Index> others = PulledEdges(*graph);
  bool all_join = true;
  for (const Index e : edges) {
    if (!graph->CanBePulled(e)) continue;
    const G from = graph->RelativePose(e), measured = graph->FactorOf(e).term->measurement;
    const double reach = Reach(e, measured.Minus(from), num_nodes, graph);
    if (!(Distance(from, measured, reach) > 1) || JoinOthers(e, from, graph)) continue;
    PullADegree(e, {kMostDegrees, reach}, graph);
    all_join = false;
  }
  if (all_join) return {};
  Advance(others, graph);
  return others;
}

template <typename G>
std::vector<Index> FarClosures<G>::GoOn(bool at_rest, CondensedGraph<G>* graph) {
  if (graph->pulled().empty()) return {};
  const int enough = AreNear(graph) ? graph->hierarchy().num_levels() : kMostWindowsOfADegree;
  if (!at_rest && windows_ < enough) return {};
  const std::vector<Index> edges = PulledEdges(*graph);
  Advance(edges, graph);
  return edges;
}

// From where they are.
template <typename G>
void FarClosures<G>::Advance(const std::vector<Index>& edges, CondensedGraph<G>* graph) {
  windows_ = 0;
  for (const Index e : edges) PullADegree(e, Pull(graph->pulled().at(e).pull), graph);
}

template <typename G>
std::vector<Index> FarClosures<G>::EndAll(CondensedGraph<G>* graph) {
  const std::vector<Index> edges = PulledEdges(*graph);
  for (const Index e : edges) graph->EndPull(e);
  return edges;
}

template class FarClosures<SE2>;
template class FarClosures<SE3>;
template class FarClosures<YawPose>;

}  // namespace hpgo
