// What holds each component of the graph in the world: the caller, or an anchor.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

// A component with neither a fixed node nor a prior is held at one node, its anchor: the oldest
// that it has, else its first node. Components are found on the top level, which is connected
// exactly as the graph is: groups are connected, and every edge between groups is lifted. Nodes are
// indices of the graph. Not synchronized.
template <typename G>
class Gauge {
 public:
  bool IsFixed(Index node) const { return fixed_.count(node) > 0; }
  // By the caller. False if nothing changes.
  bool SetFixed(Index node, bool fixed, CondensedGraph<G>* graph);
  // Before a node is removed.
  void Forget(Index node);
  void NotePriors(int added);
  // An edge came: it may join two components, each held by something.
  void NoteEdge() { is_due_ |= NumHolders() > 1; }
  void NoteRemoval() { is_due_ = true; }
  // Whether components may be held otherwise than the next update would.
  bool is_due() const { return is_due_; }

  // Where a new edge joins two components, one of which nothing but an anchor holds, that one moves
  // as a whole to fit the edge: from far off, no local solve would bring it there. To be called
  // before the new edges are put in place, while the top still shows the components as they were.
  void AlignJoined(const std::vector<Index>& new_edges, CondensedGraph<G>* graph);
  // Once they are: gives every component that the caller does not hold one anchor. Returns the
  // nodes that are free again.
  std::vector<Index> Hold(CondensedGraph<G>* graph);

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.anchors_, self.next_age_, self.fixed_, self.num_priors_, self.is_due_);
  }

 private:
  struct Components {
    std::vector<int> of_node;  // by index on the top level
    int count = 0;
  };
  static Components FindComponents(const Hierarchy<G>& hierarchy);
  std::vector<std::int64_t> FindHolders(const Components& components,
                                        const CondensedGraph<G>& graph) const;
  std::size_t NumHolders() const { return anchors_.size() + !fixed_.empty() + (num_priors_ > 0); }

  std::map<Index, std::int64_t> anchors_;  // and their age: the smaller, the older
  std::int64_t next_age_ = 0;
  std::set<Index> fixed_;  // by the caller
  int num_priors_ = 0;
  bool is_due_ = false;
};

extern template class Gauge<ceres_costs::SE2>;
extern template class Gauge<ceres_costs::SE3>;
extern template class Gauge<ceres_costs::YawPose>;

}  // namespace hpgo
