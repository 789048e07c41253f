// The condensed graph: its invariants, for tests. O(nodes + edges).

#include <sstream>

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

template <typename G>
std::string CondensedGraph<G>::FindInconsistency() {
  std::string message;
  const auto expect = [&](bool ok, const char* what, Index index) {
    if (ok || !message.empty()) return;
    std::ostringstream out;
    out << "chains: " << what << ", index " << index;
    message = out.str();
  };
  Index alive = 0;
  for (Index n = 0; n < static_cast<Index>(nodes_.size()); ++n) {
    const Node& node = nodes_[n];
    if (!node.alive) continue;
    ++alive;
    Index degree = 0, binding = 0, inside = 0, elsewhere = 0;
    ForEachEdgeOf(n, [&](Index e, Index) {
      expect(edges_[e].alive, "a dead edge at a node", n);
      ++degree;
      binding += edges_[e].binds;
      inside += edges_[e].place == Place::kChain;
      elsewhere += edges_[e].place == Place::kLevel;
    });
    expect(degree == node.degree, "degree", n);
    expect(binding == node.binding, "binding edges", n);
    expect(node.loose == (loose_.count(n) > 0), "loose", n);
    expect(!node.loose || !IsKept(n), "loose and kept", n);
    expect(!node.loose || inside + elsewhere == 0, "loose with edges in place", n);
    expect(node.loose || IsKept(n) || (inside > 0 && inside <= 2 && elsewhere == 0),
           "edges of an interior", n);
    if (IsKept(n)) expect(node_of_level_[node.level_node] == n, "node of level 0", n);
    if (node.held)
      expect(IsKept(n) && hierarchy_.level(0).nodes[node.level_node].fixed > 0, "held", n);
    if (touched_.empty()) expect(node.loose || IsKept(n) == WantsKept(n), "kept", n);
  }
  expect(alive == num_nodes_, "number of nodes", alive);
  Index placed = 0;
  for (Index e = 0; e < static_cast<Index>(edges_.size()); ++e) {
    const Edge& edge = edges_[e];
    if (!edge.alive) continue;
    if (edge.place == Place::kLevel) {
      ++placed;
      expect(edge_of_level_[edge.at] == e, "edge of level 0", e);
    } else if (edge.place == Place::kChain) {
      expect(spans_.edge(edge.at).edge == e, "edge of a chain", e);
      const Index c = ChainOf(e);
      expect(c != kNone && chains_[c].alive, "chain of an edge", e);
    }
  }
  for (Index c = 0; c < static_cast<Index>(chains_.size()); ++c) {
    Chain& chain = chains_[c];
    if (!chain.alive || !message.empty()) continue;
    const char* wrong = spans_.Inconsistency(chain.root);
    expect(*wrong == '\0', wrong, c);
    expect(spans_.OwnerOf(chain.root) == c, "owner of a tree", c);
    expect(IsEnd(chain, 0) || IsEnd(chain, 1), "a chain that hangs on nothing", c);
    placed += chain.level_edge != kNone;
    if (touched_.empty() && changed_.empty()) {
      expect((chain.level_edge != kNone) == (IsEnd(chain, 0) && IsEnd(chain, 1)), "ends", c);
    }
    Index at = chain.node[0];
    spans_.ForEachEdge(chain.root, TargetOf(chain), InsideOf(chain), [&](Index link, const G&) {
      const ChainEdge<G>& edge = spans_.edge(link);
      expect(edges_[edge.edge].node[edge.reversed] == at, "path of a chain", c);
      at = edges_[edge.edge].node[!edge.reversed];
      expect(at == chain.node[1] || !IsKept(at), "a kept node inside a chain", c);
    });
    expect(at == chain.node[1], "end of a chain", c);
  }
  for (const auto& [e, pulled] : pulled_) {
    expect(IsEdge(e) && CanBePulled(e) && pulled.pull.left > 0, "a pulled edge", e);
  }
  expect(placed == hierarchy_.level(0).num_edges, "number of edges of level 0", placed);
  return message;
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
