// Closures that are far off, taken in by degrees.
#pragma once

#include <vector>

#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

// A closure that is turned far, or displaced far beside the map around it, bends chains by more
// than a linearization says at once, and winds some of them once too often, which no descent
// undoes. So it pulls a degree of the way, then the next one, until it pulls to what it measures.
// All that are under way go on together, and a new one begins where its neighbours are, which
// measure the same displacement: at different stages they would hold each other. Changes with every
// update. Not synchronized.
template <typename G>
class FarClosures {
 public:
  // Of new or changed edges of the graph, those that are more than a degree off are under way from
  // now on. Where one is not where any other is, all begin a degree from where they are now, which
  // fits; returns the others then. `num_nodes`: of level 0, to look at around one.
  std::vector<Index> Begin(const std::vector<Index>& edges, int num_nodes,
                           CondensedGraph<G>* graph);
  // So many windows have been solved since the last call.
  void NoteWindows(int windows) { windows_ += windows; }
  // Once a window of each level has been solved and all have come near to where they pull, or
  // nothing else is to be done, or too many windows: the next degree, of each from where it is now.
  // Returns the edges that pull otherwise.
  std::vector<Index> GoOn(bool at_rest, CondensedGraph<G>* graph);
  // All pull to what they measure. Returns them.
  static std::vector<Index> EndAll(CondensedGraph<G>* graph);

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.windows_);
  }

 private:
  void Advance(const std::vector<Index>& edges, CondensedGraph<G>* graph);

  int windows_ = 0;  // since the last degree began
};

extern template class FarClosures<ceres_costs::SE2>;
extern template class FarClosures<ceres_costs::SE3>;
extern template class FarClosures<ceres_costs::YawPose>;

}  // namespace hpgo
