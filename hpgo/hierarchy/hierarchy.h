// The hierarchy of groups over a pose graph (paper, section III), kept up to date as nodes and
// edges come and go.
#pragma once

#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "hpgo/hierarchy/coarse_edges.h"
#include "hpgo/hierarchy/level.h"

namespace hpgo {

struct HierarchyOptions {
  int max_group_size = 3;   // K; at least 2
  int max_top_nodes = 150;  // T: a larger top gets a new level above it; at least 2
  int max_top_edges = std::numeric_limits<int>::max();  // so does one with more edges; at least 1
  CoarseEdges coarse_edges = CoarseEdges::kGalerkin;
  ceres_costs::ErrorConvention convention = ceres_costs::ErrorConvention::kG2o;  // of level 0
};

// What an edge or prior on level 0 is made of.
template <typename G>
struct EdgeData {
  ceres_costs::RelativePoseTerm<G> term;
  double weight = 0;                                  // of the modularity; 0 for a prior
  std::shared_ptr<const ceres::LossFunction> loss;    // null: squared
  std::shared_ptr<const ceres::CostFunction> custom;  // replaces the term's cost if set
  std::shared_ptr<const G> offset;                    // of a prior: T_node_sensor
  bool condensed = false;  // stands for a chain: the term is in the coarse convention

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.term, self.weight, self.loss, self.custom, self.offset, self.condensed);
  }
};

// The paper's W of a measurement (eq. 2): 1 / max(z' Omega z, 1e-6), z the twist of Z.
template <typename G>
double ModularityWeight(const ceres_costs::RelativePoseTerm<G>& term);

// Levels are numbered from 0, the original graph. Every node but those of the top, and new ones
// that AssignGroups has not seen, has a parent: its group. An edge between nodes of different
// groups has a parent edge between the groups; one inside a group has none. Groups are connected.
// Not synchronized. Each change costs O(levels x degree), independent of the number of nodes.
template <typename G>
class Hierarchy {
 public:
  explicit Hierarchy(const HierarchyOptions& options = {});

  const HierarchyOptions& options() const { return options_; }
  int num_levels() const { return static_cast<int>(levels_.size()); }
  const Level<G>& level(int l) const { return *levels_[l]; }
  // For those who keep pending, changed, dirty and scratch; links belong to this class.
  Level<G>& mutable_level(int l) { return *levels_[l]; }

  // --- Structure.
  // A new node of level 0 at T_world_node; grouped by the next AssignGroups.
  Index AddNode(const G& pose);
  // An edge of level 0 from i to j, both alive; i is kNone for a prior on j.
  Index AddEdge(Index i, Index j, const EdgeData<G>& data);
  void RemoveEdge(Index edge);
  // Removes the node with its edges.
  void RemoveNode(Index node);
  // Replaces the term of an edge that stands for a chain.
  void SetCondensed(Index edge, const ceres_costs::RelativePoseTerm<G>& term) {
    levels_[0]->terms[edge] = term;
  }
  // Who keeps the chains, and LevelEdge::lags: brings the term of such an edge up to date with the
  // relative pose T of its ends, knows what its edges cost, and puts it back to where it was.
  struct Chains {
    std::function<RefreshedChain(Index edge, const G& T)> refresh;
    std::function<double(Index edge, const G& T)> cost;
    std::function<void(ChainTrial trial)> try_out;
  };
  void SetChains(Chains chains) { chains_ = std::move(chains); }
  // To be called before an edge of level 0 is linearized at T; notes how much its gradient changes.
  // True if it has changed, or is a chain that lags behind: its term says nothing of T.
  bool Refresh(Index edge, const G& T) {
    return levels_[0]->edges[edge].condensed && chains_.refresh && RefreshChain(edge, T);
  }
  // Whether what Refresh does from now on may be taken back.
  void TryChains(ChainTrial trial) {
    if (trial == ChainTrial::kBegin) refreshed_before_trial_ = refreshed_.size();
    if (trial == ChainTrial::kPutBack) refreshed_.resize(refreshed_before_trial_);
    if (chains_.try_out) chains_.try_out(trial);
  }
  // Of an edge of level 0, with its ends at T; of a chain, that of its edges.
  double CostAt(Index edge, const G& T) const;
  // The edges that Refresh has changed since this was last asked, and by how much, in sqrt(chi2).
  std::vector<std::pair<Index, double>> TakeRefreshed() { return std::exchange(refreshed_, {}); }
  // Replaces measurement, information and weight of an edge.
  void UpdateEdge(Index edge, const ceres_costs::RelativePoseTerm<G>& term, double weight);
  // Replaces the loss of an edge; null: squared.
  void SetLoss(Index edge, std::shared_ptr<const ceres::LossFunction> loss);
  // Whether a node waits for AssignGroups to get a group.
  bool IsWaiting(int l, Index node) const {
    for (const LevelItem& item : unassigned_) {
      if (item.l == l && item.index == node) return true;
    }
    return false;
  }
  // For a top, by a multiple of what one may hold.
  bool IsTooLarge(int l, double share = 1) const;
  // Algorithm 1 for the nodes without a group; builds a new level when the top has grown too large.
  void AssignGroups();
  void SetFixed(Index node, bool fixed);

  // --- Poses.
  G WorldPose(int l, Index node) const;
  // X_a^-1 X_b of two nodes of a level; a kNone: T_world_b.
  G RelativePose(int l, Index a, Index b) const;
  // Moves a node with all that is below it, so that it stands at T_world_node.
  void SetWorldPose(int l, Index node, const G& pose);
  // Replaces T_parent_node.
  void SetLocalPose(int l, Index node, const G& pose);
  Index Ancestor(Index node, int l) const;

  // --- Edges.
  ceres_costs::FactorTerm<G> FactorOf(int l, Index edge) const;
  // That of an edge which is not yet there; borrows from `data`.
  ceres_costs::FactorTerm<G> FactorOf(const EdgeData<G>& data) const;
  // Computes a coarse edge from its children at the current estimate; see coarse_edge.h.
  // Returns how much the quadratic changed, in sqrt(chi2).
  double Merge(int l, Index edge);
  // How much the cost falls when the relative pose of an edge's ends changes, the groups rigid:
  // that of the edges of level 0 which it stands for. Looks at no more than `*budget` edges below
  // l, and counts them off; a coarse edge beyond that speaks for its children.
  double CostDecrease(int l, Index edge, const G& before, const G& after, int* budget) const;
  // Queues a coarse edge for merging.
  void MarkDirty(int l, Index edge);
  // Sets an edge's pending, and its place in the queue: there only above `threshold` on.
  void SetPending(int l, Index edge, float pending, float threshold);

  // --- Motions. Calls visit(node of level 0, T_world_node) for the poses that have moved by more
  // than `distance` (m) or `angle` (rad) since each was last visited, and for new nodes. Only parts
  // of the hierarchy whose bounds exceed these are looked at. The first call visits all and starts
  // the tracking, which costs every later change of a pose O(levels).
  void ForEachMoved(double distance, double angle,
                    const std::function<void(Index, const G&)>& visit) {
    LookAtMoved(distance, angle, nullptr, visit);
  }
  // The same for what hangs on nodes of level 0 within HangBelow: `look` is called for every node
  // that may have moved with it, whether or not it has itself.
  void LookAtMoved(double distance, double angle, const std::function<void(Index, const G&)>& look,
                   const std::function<void(Index, const G&)>& visit);
  // While motions are tracked: something hangs on a node of level 0, `reach` m away at most.
  // `moved`: to be looked at whatever moves.
  void HangBelow(Index node, float reach, bool moved);

  // A mark for LevelNode::stamp that no node has yet.
  std::uint32_t NewStamp() { return ++stamp_; }

  std::size_t MemoryBytes() const;

 private:
  // What few edges have: they alone pay for it.
  struct Extra {
    std::shared_ptr<const ceres::LossFunction> loss;
    std::shared_ptr<const ceres::CostFunction> custom;
    std::shared_ptr<const G> offset;

    template <typename Archive, typename Self>
    static void Fields(Archive& archive, Self& self) {
      archive(self.loss, self.custom, self.offset);
    }
  };
  struct LevelItem {
    int l;
    Index index;

    template <typename Archive, typename Self>
    static void Fields(Archive& archive, Self& self) {
      archive(self.l, self.index);
    }
  };

  bool RefreshChain(Index edge, const G& T);

  // hierarchy_moves.cc
  void StartTracking();
  void NoteMove(int l, Index node, const G& before);
  void RaiseBounds(int l, Index node);
  void RaiseRadius(int l, Index node);
  void VisitMoved(int l, Index node, const MotionBound& limit,
                  const std::function<void(Index, const G&)>& look,
                  const std::function<void(Index, const G&)>& visit);

  // hierarchy_links.cc
  Index NewNode(int l, const G& pose);
  void FreeNode(int l, Index node);
  Index LinkEdge(int l, Index i, Index j, double weight);
  void UnlinkEdge(int l, Index edge);
  void AddWeight(int l, Index edge, double delta);
  void Lift(int l, Index edge);
  void Unlift(int l, Index edge);
  void EraseEdge(int l, Index edge);
  Index NewExtra(Extra extra);
  void MarkAncestorsDirty(int l, Index edge);
  void AddFixed(int l, Index node, int delta);
  Index FindEdge(int l, Index i, Index j) const;

  // hierarchy_groups.cc
  void Attach(int l, Index node, Index group);
  void Detach(int l, Index node);
  void DetachAndForget(int l, Index node);
  void AssignGroup(int l, Index node);
  // Queues a node that is alone in its group and has a new neighbour: it may join another now
  // (Algorithm 1 moves no node out of a larger group).
  void RetryIfAlone(int l, Index node);
  void RepairGroups();
  bool SplitGroup(int l, Index group);
  void AddLevel();
  // Has the condensed edges of the new top say what the estimate says.
  void CentreTop();
  void DropTop();
  void DropSmallTop();

  HierarchyOptions options_;
  std::uint32_t stamp_ = 0;
  Index next_new_level_ = 0;  // nodes and edges of the top from which on a level is tried above it
  bool tracking_ = false;
  ChunkedVector<G> reported_;  // while tracking: T_world_node as last visited, by node of level 0
  std::vector<std::unique_ptr<Level<G>>> levels_;
  std::vector<LevelItem> unassigned_;  // nodes without a group on levels below the top
  std::vector<LevelItem> suspects_;    // groups that may have come apart
  ChunkedVector<Extra> extras_;        // by LevelEdge::extra
  Chains chains_;
  std::vector<std::pair<Index, double>> refreshed_;
  std::size_t refreshed_before_trial_ = 0;
  std::vector<Index> free_extras_;

 public:
  // What a saved state has of the fields above: all but the options, and stamps.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.next_new_level_, self.tracking_, self.reported_, self.levels_, self.unassigned_,
            self.suspects_, self.extras_, self.refreshed_, self.free_extras_);
  }
};

extern template class Hierarchy<ceres_costs::SE2>;
extern template class Hierarchy<ceres_costs::SE3>;
extern template class Hierarchy<ceres_costs::YawPose>;

}  // namespace hpgo
