// A bounded part of one level as a Subproblem: breadth-first around its seeds, with the nodes on
// its border held (paper, section IV.B).
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

struct WindowLimits {
  int max_nodes = 100;   // P: free nodes
  int max_edges = 1000;  // a seed with more of its own gets a window alone
};

// What becomes of the nodes beyond the border: they are held, or left out with the edges to them,
// but for constant ones.
enum class Beyond { kHeld, kLeftOut };

// Reusable: keeps its storage from window to window. Not synchronized.
template <typename G>
class Window {
 public:
  // Collects up to max_nodes free nodes, breadth-first from the seeds, and every edge at one of
  // them. Constant nodes (LevelNode::fixed) are border. Where nothing else holds the gauge, the
  // first node is. False if no node is free.
  bool Build(int l, const std::vector<Index>& seeds, const WindowLimits& limits,
             Hierarchy<G>* hierarchy, Beyond beyond = Beyond::kHeld);
  // The whole level.
  bool BuildWhole(int l, Hierarchy<G>* hierarchy, bool refresh_chains = true);

  Subproblem<G>& subproblem() { return subproblem_; }
  int level() const { return level_; }
  int num_free() const { return subproblem_.num_free; }
  // The nodes in the order of the subproblem's poses, and the edges in the order of its factors.
  const std::vector<Index>& nodes() const { return nodes_; }
  const std::vector<Index>& edges() const { return edges_; }
  bool IsFree(Index node) const;
  bool IsInterior(std::size_t edge) const;  // both ends free
  // The relative pose of the edge edges()[k] at the subproblem's poses, and when it was built.
  G RelativePose(std::size_t k) const { return Relative(k, subproblem_.poses); }
  G RelativePoseBefore(std::size_t k) const { return Relative(k, before_); }
  // Those of two nodes of level 0, before and now; none where a step does not move them against
  // each other.
  std::optional<std::pair<G, G>> PosesBetween(Index i, Index j) const;
  // T_before_now of the node nodes()[k].
  G Moved(std::size_t k) const { return before_[k].Between(subproblem_.poses[k]); }

  // On level 0: linearizes anew, at the subproblem's poses, the chains that are bent there. True if
  // there were any, or some that could not follow: the cost is another one then.
  bool RefreshChains();
  // Whether a chain does not follow its ends: its factor does not say what it costs.
  bool Lags() const;
  // On level 0, at the subproblem's poses. Of chains that lag behind, that of their edges.
  double Cost() const;
  // For another solve of what is there: what has been committed, its chains refreshed, is where it
  // begins.
  void Restart();
  // Leaves a share of the motion since then.
  void ShortenStep(double share);
  // Puts the poses back to where the solve began.
  void TakeBack();
  // Writes the free poses into the hierarchy.
  void Commit(Hierarchy<G>* hierarchy) const;

 private:
  void Collect(const std::vector<Index>& seeds, const WindowLimits& limits);
  bool TryAdd(Index node, int max_edges);
  void AddFactors(Beyond beyond, bool refresh_chains);
  void HoldGauge();
  const G& FrameOf(int l, Index node);
  G Relative(std::size_t k, const std::vector<G>& poses) const {
    return hpgo::RelativePose(subproblem_.factors[k], poses);
  }

  Hierarchy<G>* hierarchy_ = nullptr;
  int level_ = 0;
  // Of the nodes that are in the window, and of those that had no place in it.
  std::uint32_t stamp_ = 0, refused_ = 0;
  int num_edges_ = 0;
  std::vector<Index> nodes_, edges_;
  std::vector<G> frames_;  // T_world_group of the ancestors met, by their scratch
  std::vector<G> before_;
  Subproblem<G> subproblem_;
};

extern template class Window<ceres_costs::SE2>;
extern template class Window<ceres_costs::SE3>;
extern template class Window<ceres_costs::YawPose>;

}  // namespace hpgo
