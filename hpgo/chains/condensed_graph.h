// A pose graph whose chains are condensed: the hierarchy's level 0 is the kept nodes, and a chain
// between two of them is one edge there.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "hpgo/chains/condensed_records.h"
#include "hpgo/chains/span_tree.h"
#include "hpgo/hierarchy/hierarchy.h"

namespace hpgo {

// Owns the graph as its caller sees it, by indices of its own, and the hierarchy over its kept
// nodes. A node is kept if it is held, has a prior or three edges or more, or an edge that binds:
// one that closed a loop when it came, or that no chain can hold (a loss, a cost of the caller's,
// information that is not positive definite), or is turned too far for one. Any other node with
// edges is the interior of a chain, or the free end of one that hangs on a single kept node; its
// pose follows from the kept nodes: the conditional mean, the exact optimum given them. A node
// without edges is loose and stays where it was put.
//
// Changes wait for Restructure, which costs O(log n) each. Not synchronized.
template <typename G>
class CondensedGraph {
 public:
  // `condense` false: every node is kept.
  CondensedGraph(const HierarchyOptions& options, bool condense);
  CondensedGraph(const CondensedGraph&) = delete;
  CondensedGraph& operator=(const CondensedGraph&) = delete;

  Hierarchy<G>& hierarchy() { return hierarchy_; }
  const Hierarchy<G>& hierarchy() const { return hierarchy_; }

  // --- The graph.
  Index AddNode(const G& pose);
  // From i to j, both alive; i is kNone for a prior on j.
  Index AddEdge(Index i, Index j, const EdgeData<G>& data);
  void RemoveEdge(Index edge);
  void RemoveNode(Index node);  // with its edges
  // Replaces the measurement of an edge without a cost of its own.
  void UpdateEdge(Index edge, const ceres_costs::RelativePoseTerm<G>& term);
  // Replaces the loss of an edge; null: squared.
  void SetLoss(Index edge, std::shared_ptr<const ceres::LossFunction> loss);
  // A held node does not move.
  void SetHeld(Index node, bool held);
  bool IsHeld(Index node) const { return nodes_[node].held; }

  Index num_nodes() const { return num_nodes_; }
  Index num_edges() const { return num_edges_; }
  // Past the largest indices of a node and of an edge ever given.
  Index end_of_nodes() const { return static_cast<Index>(nodes_.size()); }
  Index end_of_edges() const { return static_cast<Index>(edges_.size()); }
  bool IsNode(Index node) const {
    return node < static_cast<Index>(nodes_.size()) && nodes_[node].alive;
  }
  bool IsEdge(Index edge) const { return edge < end_of_edges() && edges_[edge].alive; }
  std::uint32_t Generation(Index edge) const { return edges_[edge].generation; }
  Index End(Index edge, int side) const { return edges_[edge].node[side]; }
  int Degree(Index node) const { return nodes_[node].degree; }
  // visit(edge, other end or kNone), newest first.
  template <typename Visitor>
  void ForEachEdgeOf(Index node, Visitor&& visit) const {
    for (Index e = nodes_[node].first_edge; e != kNone;) {
      const Edge& edge = edges_[e];
      const int side = edge.node[1] == node;
      const Index next = edge.next[side];
      visit(e, edge.node[1 - side]);
      e = next;
    }
  }
  ceres_costs::FactorTerm<G> FactorOf(Index edge) const;

  // --- Poses: T_world_node. O(levels + log n) each.
  G WorldPose(Index node);
  void SetWorldPose(Index node, const G& pose);
  G RelativePose(Index edge);
  // visit(node, pose) for all nodes; visit(edge, relative pose of its ends) for all edges, priors
  // with T_world_node. O(nodes + edges).
  void ForEachPose(const std::function<void(Index, const G&)>& visit);
  void ForEachRelativePose(const std::function<void(Index, const G&)>& visit);
  // As Hierarchy::ForEachMoved, interiors among them.
  void ForEachMoved(double distance, double angle,
                    const std::function<void(Index, const G&)>& visit);

  // --- Level 0.
  // What the model of a chain may miss, in sqrt(chi2), before it is linearized anew.
  void SetTolerance(double tolerance) { tolerance_ = tolerance; }
  // How many edges in chains have been linearized anew or asked what they cost, one by one, since
  // the graph was made or loaded.
  std::int64_t visited_edges() const { return visited_; }
  // Takes in all changes: finds the kept nodes, cuts and joins chains, and puts edges on level 0.
  // New nodes without a held one or an older one in their component get a kept one, their first.
  void Restructure();
  // How many nodes wait for it, the ends among them of edges that were found to be no part for a
  // chain in the meantime.
  std::size_t num_changes() const { return touched_.size(); }
  // Linearizes all chains anew where they are, for those who want the very optimum. O(edges).
  void SettleAll();
  // Linearizes all chains between kept nodes where `poses`, T_world_node by node, have their nodes;
  // the kept ones are moved there by the caller. O(edges).
  void LinearizeChainsAt(const std::vector<G>& poses);
  // What the last Restructure has placed.
  const std::vector<PlacedEdge>& placed() const { return placed_; }
  // New nodes since the last Restructure that begin a component.
  bool has_new_component() const { return has_new_component_; }
  bool IsKept(Index node) const { return nodes_[node].level_node != kNone; }
  Index LevelNodeOf(Index node) const { return nodes_[node].level_node; }
  Index NodeOfLevel(Index level_node) const { return node_of_level_[level_node]; }
  // The edge that is one of level 0 by itself; kNone if that is a chain.
  Index EdgeOfLevel(Index level_edge) const;
  // The edge of level 0 that an edge is, or is a part of; kNone if it hangs free or is new.
  Index LevelEdgeOf(Index edge) const;
  // The nodes that the last Restructure has kept for want of another kept one: each the first of
  // its component.
  const std::vector<Index>& roots() const { return roots_; }
  // For messages: the first and last node of an edge of level 0.
  Index EndOfLevel(Index level_edge, int side) const {
    const Index n = hierarchy_.level(0).edges[level_edge].node[side];
    return n == kNone ? kNone : node_of_level_[n];
  }
  // The chain that a node is inside of, or the free end of; kNone of any other.
  Index ChainOfNode(Index node) const;
  // The ends of a chain; one may be free.
  Index EndOfChain(Index chain, int side) const { return chains_[chain].node[side]; }
  // Its edge of level 0; kNone where an end is free.
  Index LevelEdgeOfChain(Index chain) const { return chains_[chain].level_edge; }
  // The chain cut at some of its nodes, in order; what hangs free behind the last is left out.
  // Changes nothing. O(log n) a node.
  std::vector<Stretch<G>> CutChain(Index chain, const std::vector<Index>& nodes);
  // A kept node of the same component: the node itself, or an end of its chain; kNone if loose or
  // not yet restructured.
  Index KeptNear(Index node) const;
  // Whether most edges are part of one.
  bool IsMostlyChains() const { return 2 * hierarchy_.level(0).num_edges <= num_edges_; }

  // --- Pulls: an edge of level 0 that pulls a part of the way to what it measures, which FactorOf
  // goes on to say. Removing or changing the edge, or its loss, ends its pull.
  // Whether it can: it closes a loop, measures all directions, and has no loss and no cost of its
  // own.
  bool CanBePulled(Index edge) const;
  void PullTowards(Index edge, const G& T_i_j, const Pull& pull);
  void EndPull(Index edge);
  // Those that are, by edge.
  const std::map<Index, PulledEdge<G>>& pulled() const { return pulled_; }
  // Where one pulls to, T_i_j.
  const G& PullOf(Index edge) const {
    return hierarchy_.FactorOf(0, edges_[edge].at).term->measurement;
  }

  std::size_t MemoryBytes() const;
  // Empty if all is well, else the first thing wrong; for tests.
  std::string FindInconsistency();

 private:
  using Place = EdgePlace;
  using Node = NodeRecord;
  using Edge = EdgeRecord;
  using Chain = ChainRecord<G>;
  // A chain as it was before a trial.
  struct BeforeTrial {
    Index chain;
    bool lags;
    double chi2;
    ceres_costs::RelativePoseTerm<G> term;
  };

  void SetTerm(Chain* chain, const G& T);
  void NoteChi2(Chain* chain);
  void PlaceOnLevel(Index edge, EdgeData<G> data, bool is_new);
  void FinishChain(Index chain);
  void SetLags(Chain* chain, bool lags);
  void LinearizeWhereItIs(Chain* chain, const G& T);
  bool Settle(Chain* chain, const G& T);
  double ChiSquareAt(const Chain& chain, const G& T) const;
  bool Misses(const Chain& chain, double bend, double chi2) const;
  RefreshedChain Refresh(Index level_edge, const G& T);
  void Try(ChainTrial trial);
  double CostOfChain(Index level_edge, const G& T);
  void BindUnfit();

  // condensed_graph_edit.cc
  void DropChainOf(Index edge);
  void Link(Index edge);
  void Unlink(Index edge);
  void Touch(Index node);
  static bool MeasuresAll(const ceres_costs::RelativePoseTerm<G>& term);
  static bool Binds(const ceres_costs::FactorTerm<G>& factor);
  void Bind(Index edge);
  bool WantsKept(Index node) const;

  // condensed_graph_pull.cc
  void SetTermOfLevel(Index edge, const ceres_costs::RelativePoseTerm<G>& term);

  // condensed_graph_restructure.cc
  Index NewChain(Index from, Index to, Index root);
  void FreeChain(Index chain);
  void MarkChanged(Index chain);
  void DropLevelEdge(Index chain);
  Index ChainOf(Index edge) const { return spans_.OwnerOf(spans_.RootOf(edges_[edge].at)); }
  void CutAt(Index node);
  void Keep(Index node);
  void Release(Index node);
  void MakeChainOf(Index edge, const ceres_costs::RelativePoseTerm<G>& term, bool is_new);
  void JoinAt(Index node);

  // condensed_graph_new_nodes.cc
  std::vector<Index> LooseByAge() const;
  double LengthOfFreeEnd(Index node) const;
  void PoseNewNodes(const std::vector<Index>& loose);
  void FindRoots(const std::vector<Index>& loose);

  // chain_pieces.cc
  // The node that an edge of the span tree leads to, along its chain, and the edge that leads to a
  // node inside of one; kNone at a chain's first node.
  Index EnteredBy(Index at) const {
    return edges_[spans_.edge(at).edge].node[!spans_.edge(at).reversed];
  }
  Index EdgeInto(Index node) const;

  // condensed_graph_poses.cc
  bool IsEnd(const Chain& chain, int side) const { return IsKept(chain.node[side]); }
  static Inside InsideOf(const Chain& chain) {
    return chain.lags ? Inside::kYields : Inside::kMean;
  }
  G TargetOf(Chain& chain);
  G OriginOf(const Chain& chain, const G& T);
  G InteriorPose(Index node);
  template <typename Visitor>
  void ForEachInterior(Chain& chain, Visitor&& visit);
  void ComposeFreeEnd(Chain* chain);
  void NoteReach(const Chain& chain, bool moved);

  Hierarchy<G> hierarchy_;
  const bool condense_;
  SpanTree<G> spans_;
  double tolerance_ = 0;
  std::int64_t visited_ = 0;
  bool is_trial_ = false;
  std::vector<BeforeTrial> before_trial_;  // of the chains that have been refreshed since
  LinearizationLog<G> trial_log_;          // of their spans and edges
  ChunkedVector<Node> nodes_;
  ChunkedVector<Edge> edges_;
  ChunkedVector<Index> node_of_level_;     // by node of level 0
  ChunkedVector<Index> edge_of_level_;     // by edge of level 0: an edge, or ~chain
  std::map<Index, PulledEdge<G>> pulled_;  // by edge
  std::vector<Chain> chains_;
  std::vector<Index> free_nodes_, free_edges_, free_chains_;
  Index num_nodes_ = 0, num_edges_ = 0;
  std::uint32_t next_born_ = 0;
  std::uint32_t first_new_ = 0;  // nodes born since have not been through Restructure
  // Changes since the last Restructure.
  std::map<Index, EdgeData<G>> new_data_;  // of new edges
  std::map<Index, G> loose_;               // poses of nodes that are neither kept nor in a chain
  std::vector<Index> touched_;             // nodes
  std::vector<Index> changed_;             // chains
  std::vector<Index> roots_;               // nodes that the last Restructure kept as roots
  bool has_new_component_ = false;
  std::vector<PlacedEdge> placed_;
  // While motions are tracked: T_world_node as last visited.
  bool tracking_ = false;
  std::uint32_t moved_stamp_ = 0;
  ChunkedVector<G> reported_;      // by node
  std::vector<Index> unreported_;  // nodes to look at whatever moves

 public:
  // What a saved state has of the fields above: all but the options.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive.Section("levels");
    archive(self.hierarchy_, self.node_of_level_, self.edge_of_level_, self.pulled_);
    archive.Section("chains");
    archive(self.spans_, self.chains_, self.free_chains_, self.changed_, self.tolerance_);
    archive.Section("edges");
    archive(self.nodes_, self.edges_, self.free_nodes_, self.free_edges_, self.num_nodes_,
            self.num_edges_, self.next_born_, self.first_new_, self.new_data_, self.loose_,
            self.touched_, self.roots_, self.has_new_component_, self.placed_, self.tracking_,
            self.moved_stamp_, self.reported_, self.unreported_);
  }
};

extern template class CondensedGraph<ceres_costs::SE2>;
extern template class CondensedGraph<ceres_costs::SE3>;
extern template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
