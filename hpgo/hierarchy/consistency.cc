#include "hpgo/hierarchy/consistency.h"

#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "ceres_costs/finite.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

bool IsUnit(const SE3& pose) { return std::abs(pose.rotation().norm() - 1) < 1e-9; }
template <typename G>
bool IsUnit(const G& pose) {
  return std::abs(pose.angle()) <= 3.15;
}

bool Close(double a, double b) { return std::abs(a - b) <= 1e-6 * (1 + std::abs(a) + std::abs(b)); }

template <typename G>
class Checker {
 public:
  explicit Checker(const Hierarchy<G>& h) : h_(h) {}

  std::string Run() {
    for (int l = 0; l < h_.num_levels() && message_.empty(); ++l) {
      l_ = l;
      Counts();
      for (Index n = 0; n < Size(Here().nodes); ++n) {
        if (Here().nodes[n].alive) Node(n);
      }
      for (Index e = 0; e < Size(Here().edges); ++e) {
        if (Here().edges[e].alive) Edge(e);
      }
      std::size_t queued = 0;
      Here().pending.ForEach(Here().edges, [&](Index e) {
        ++queued;
        Expect(Here().edges[e].alive && Here().edges[e].queued, "pending edge", e);
      });
      Expect(queued == Here().pending.size(), "number of pending edges", 0);
    }
    return message_;
  }

 private:
  template <typename C>
  static Index Size(const C& c) {
    return static_cast<Index>(c.size());
  }
  const Level<G>& Here() const { return h_.level(l_); }
  bool HasAbove() const { return l_ + 1 < h_.num_levels(); }

  void Expect(bool ok, const char* what, Index index) {
    if (ok || !message_.empty()) return;
    std::ostringstream out;
    out << "level " << l_ << ", " << what << ", index " << index;
    message_ = out.str();
  }

  void Counts() {
    Index nodes = 0, edges = 0;
    double weight = 0;
    for (Index n = 0; n < Size(Here().nodes); ++n) nodes += Here().nodes[n].alive;
    for (Index e = 0; e < Size(Here().edges); ++e) {
      edges += Here().edges[e].alive;
      if (Here().edges[e].alive) weight += Here().edges[e].weight;
    }
    Expect(nodes == Here().num_nodes, "number of nodes", nodes);
    Expect(edges == Here().num_edges, "number of edges", edges);
    Expect(Close(weight, Here().total_weight), "total weight", 0);
    Expect(Here().free_nodes.size() + nodes == Here().nodes.size(), "free nodes", nodes);
    Expect(Here().free_edges.size() + edges == Here().edges.size(), "free edges", edges);
  }

  void Node(Index n) {
    const LevelNode<G>& node = Here().nodes[n];
    Index degree = 0;
    double weight = 0;
    ForEachEdge(Here(), n, [&](Index e, Index) {
      const LevelEdge& edge = Here().edges[e];
      Expect(edge.alive && (edge.node[0] == n || edge.node[1] == n), "adjacency of node", n);
      ++degree;
      weight += edge.weight;
    });
    Expect(degree == node.degree, "degree of node", n);
    Expect(Close(weight, node.weight), "weight of node", n);
    Expect(IsUnit(node.pose) && IsFinite(node.pose), "pose of node", n);
    if (node.parent != kNone) {
      Expect(HasAbove() && h_.level(l_ + 1).nodes[node.parent].alive, "parent of node", n);
    } else {
      Expect(!HasAbove() || h_.IsWaiting(l_, n), "node without a group", n);
    }
    if (l_ > 0) Group(n);
  }

  void Group(Index n) {
    const Level<G>& below = h_.level(l_ - 1);
    const LevelNode<G>& node = Here().nodes[n];
    std::set<Index> members;
    int fixed = 0;
    for (Index c = node.first_child; c != kNone; c = below.nodes[c].next_sibling) {
      Expect(below.nodes[c].alive && below.nodes[c].parent == n, "child of group", n);
      if (!members.insert(c).second) return Expect(false, "cycle in the children of group", n);
      fixed += below.nodes[c].fixed > 0;
    }
    Expect(Size(members) == node.num_children && !members.empty(), "number of children", n);
    Expect(node.num_children <= h_.options().max_group_size, "size of group", n);
    Expect(fixed == node.fixed, "fixed count of group", n);
    if (members.empty()) return;
    std::vector<Index> queue = {*members.begin()};
    members.erase(members.begin());
    while (!queue.empty()) {
      const Index c = queue.back();
      queue.pop_back();
      ForEachEdge(below, c, [&](Index, Index other) {
        if (members.erase(other) > 0) queue.push_back(other);
      });
    }
    Expect(members.empty(), "connectedness of group", n);
  }

  void Edge(Index e) {
    const LevelEdge& edge = Here().edges[e];
    Expect(edge.node[1] != kNone && edge.node[0] != edge.node[1], "ends of edge", e);
    const bool unary = edge.node[0] == kNone;
    if (HasAbove()) {
      const Index p = unary ? kNone : Here().nodes[edge.node[0]].parent;
      const Index q = Here().nodes[edge.node[1]].parent;
      if (!unary && p == q) {
        Expect(edge.parent == kNone, "parent of an edge inside a group", e);
      } else {
        Expect(edge.parent != kNone, "edge not lifted", e);
        if (edge.parent == kNone) return;
        const LevelEdge& up = h_.level(l_ + 1).edges[edge.parent];
        Expect(up.alive &&
                   ((up.node[0] == p && up.node[1] == q) || (up.node[0] == q && up.node[1] == p)),
               "ends of the parent of edge", e);
      }
    } else {
      Expect(edge.parent == kNone, "parent of a top edge", e);
    }
    if (l_ == 0) return;
    const Level<G>& below = h_.level(l_ - 1);
    Index children = 0;
    double weight = 0;
    for (Index c = edge.first_child; c != kNone; c = below.edges[c].next_sibling) {
      Expect(below.edges[c].alive && below.edges[c].parent == e, "child of edge", e);
      weight += below.edges[c].weight;
      if (++children > edge.num_children) break;
    }
    Expect(children == edge.num_children && children > 0, "number of children of edge", e);
    Expect(Close(weight, edge.weight), "weight of edge", e);
    const std::pair<Index, Index> ends = std::minmax(edge.node[0], edge.node[1]);
    Expect(pairs_[l_].insert(ends).second, "two coarse edges between the same groups", e);
  }

  const Hierarchy<G>& h_;
  int l_ = 0;
  std::map<int, std::set<std::pair<Index, Index>>> pairs_;
  std::string message_;
};

}  // namespace

template <typename G>
std::string FindInconsistency(const Hierarchy<G>& hierarchy) {
  return Checker<G>(hierarchy).Run();
}

template std::string FindInconsistency(const Hierarchy<SE2>&);
template std::string FindInconsistency(const Hierarchy<SE3>&);
template std::string FindInconsistency(const Hierarchy<YawPose>&);

}  // namespace hpgo
