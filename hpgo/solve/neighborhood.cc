#include "hpgo/solve/neighborhood.h"

#include <algorithm>
#include <limits>

#include "hpgo/hierarchy/coarse_edge.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// Finds ways in the hierarchy, breadth-first.
template <typename G>
class Ways {
 public:
  explicit Ways(Hierarchy<G>* hierarchy) : hierarchy_(hierarchy) {}

  // From a node of level 0 to another one; `to` kNone: to one that is constant or has a prior.
  // Empty if there is none.
  std::vector<Index> Find(Index from, Index to) {
    const std::vector<Index> start = Ancestors(from);
    const std::vector<Index> goal = to == kNone ? std::vector<Index>() : Ancestors(to);
    std::vector<Index> way;
    for (int l = static_cast<int>(start.size()) - 1; l >= 0; --l) {
      way = Search(l, start[l], to == kNone ? kNone : goal[l], way);
      if (way.empty()) break;
    }
    return way;
  }

 private:
  std::vector<Index> Ancestors(Index n) const {
    std::vector<Index> ancestors;
    for (int l = 0; n != kNone; ++l) {
      ancestors.push_back(n);
      n = hierarchy_->level(l).nodes[n].parent;
    }
    return ancestors;
  }

  bool IsAnchored(const Level<G>& level, Index n) const {
    bool anchored = level.nodes[n].fixed > 0;
    ForEachEdge(level, n, [&](Index, Index other) { anchored |= other == kNone; });
    return anchored;
  }

  // On one level, within some groups of the level above; anywhere if there are none.
  std::vector<Index> Search(int l, Index from, Index to, const std::vector<Index>& within) {
    Level<G>& level = hierarchy_->mutable_level(l);
    const std::uint32_t allowed = hierarchy_->NewStamp(), visited = hierarchy_->NewStamp();
    for (const Index group : within) {
      for (Index c = hierarchy_->level(l + 1).nodes[group].first_child; c != kNone;
           c = level.nodes[c].next_sibling) {
        level.nodes[c].stamp = allowed;
      }
    }
    queue_.clear();
    before_.clear();
    const auto add = [&](Index n, Index before) {
      LevelNode<G>& node = level.nodes[n];
      if (node.stamp == visited || (!within.empty() && node.stamp != allowed)) return;
      node.stamp = visited;
      queue_.push_back(n);
      before_.push_back(before);
    };
    add(from, kNone);
    for (std::size_t k = 0; k < queue_.size(); ++k) {
      const Index n = queue_[k];
      if (to == kNone ? IsAnchored(level, n) : n == to) {
        std::vector<Index> way;
        for (Index at = static_cast<Index>(k); at != kNone; at = before_[at]) {
          way.push_back(queue_[at]);
        }
        std::reverse(way.begin(), way.end());
        return way;
      }
      ForEachEdge(level, n, [&](Index, Index other) {
        if (other != kNone) add(other, static_cast<Index>(k));
      });
    }
    return {};
  }

  Hierarchy<G>* const hierarchy_;
  std::vector<Index> queue_, before_;  // workspace: nodes, and where in it each was seen from
};

// Breadth-first around some nodes of level 0. True if nothing of their components is missing.
template <typename G>
bool GrowAround(int max_nodes, Hierarchy<G>* hierarchy, std::vector<Index>* nodes) {
  Level<G>& level = hierarchy->mutable_level(0);
  const std::uint32_t stamp = hierarchy->NewStamp();
  std::vector<Index> list;
  const auto add = [&](Index n) {
    if (level.nodes[n].stamp == stamp) return;
    level.nodes[n].stamp = stamp;
    list.push_back(n);
  };
  for (const Index n : *nodes) add(n);
  bool whole = true;
  for (std::size_t k = 0; k < list.size(); ++k) {
    if (level.nodes[list[k]].fixed > 0) continue;  // nothing passes a constant node
    ForEachEdge(level, list[k], [&](Index, Index other) {
      if (other == kNone || level.nodes[other].stamp == stamp) return;
      if (static_cast<int>(list.size()) < max_nodes) {
        add(other);
      } else {
        whole = false;
      }
    });
  }
  nodes->swap(list);
  return whole;
}

template <typename G>
class NeighborhoodBuilder {
 public:
  NeighborhoodBuilder(const std::vector<Index>& nodes, CondensedGraph<G>* graph,
                      Neighborhood<G>* neighborhood)
      : nodes_(nodes), graph_(*graph), result_(*neighborhood) {}

  Status Build(int max_nodes) {
    std::vector<Index> around, ends;
    for (const Index n : nodes_) {
      const Index chain = graph_.ChainOfNode(n);
      if (chain == kNone && !graph_.IsKept(n)) return NotThere();
      ends.push_back(graph_.LevelNodeOf(graph_.KeptNear(n)));
      for (int side = 0; side < 2 && chain != kNone; ++side) {
        const Index end = graph_.EndOfChain(chain, side);
        if (graph_.IsKept(end)) around.push_back(graph_.LevelNodeOf(end));
      }
    }
    const std::vector<Index> way =
        Ways<G>(&graph_.hierarchy()).Find(ends[0], ends.size() > 1 ? ends[1] : kNone);
    if (way.empty()) return NotThere();
    around.insert(around.end(), way.begin(), way.end());
    result_.whole = GrowAround(max_nodes, &graph_.hierarchy(), &around);
    WindowLimits all;
    all.max_nodes = 0;
    for (const Index n : around) all.max_nodes += graph_.hierarchy().level(0).nodes[n].fixed == 0;
    all.max_edges = std::numeric_limits<int>::max() / 2;
    result_.window.Build(0, around, all, &graph_.hierarchy(), Beyond::kLeftOut);
    AddInteriors();
    return Status::Ok();
  }

 private:
  static Status NotThere() {
    return Status(StatusCode::kNoSolution,
                  "nothing leads to the pose from what holds it, as of the last update");
  }

  // The nodes asked for that chains hold, with the pieces of these instead of them.
  void AddInteriors() {
    Subproblem<G>& problem = result_.problem();
    std::vector<Index> interiors, chains;
    for (const Index n : nodes_) {
      const Index chain = graph_.ChainOfNode(n);
      if (chain == kNone) continue;
      interiors.push_back(n);
      if (std::find(chains.begin(), chains.end(), chain) == chains.end()) chains.push_back(chain);
    }
    const int first = problem.num_free, count = static_cast<int>(interiors.size());
    problem.poses.insert(problem.poses.begin() + first, count, G());
    for (int k = 0; k < count; ++k) problem.poses[first + k] = graph_.WorldPose(interiors[k]);
    problem.num_free += count;
    for (Factor<G>& factor : problem.factors) {
      factor.i += factor.i >= first ? count : 0;
      factor.j += factor.j >= first ? count : 0;
    }
    const auto index_of = [&](Index n) {
      const auto interior = std::find(interiors.begin(), interiors.end(), n);
      if (interior != interiors.end())
        return first + static_cast<int>(interior - interiors.begin());
      const Index level_node = graph_.LevelNodeOf(n);
      const std::vector<Index>& kept = result_.window.nodes();
      const auto at = std::find(kept.begin(), kept.end(), level_node);
      if (at == kept.end()) {  // constant, without another edge here
        problem.poses.push_back(graph_.WorldPose(n));
        return static_cast<int>(problem.poses.size()) - 1;
      }
      const int k = static_cast<int>(at - kept.begin());
      return k < first ? k : k + count;
    };
    std::vector<int> replaced;  // factors of the chains that are cut
    for (const Index chain : chains) {
      const std::vector<Index>& edges = result_.window.edges();
      const auto whole = std::find(edges.begin(), edges.end(), graph_.LevelEdgeOfChain(chain));
      if (whole != edges.end()) replaced.push_back(static_cast<int>(whole - edges.begin()));
      const auto stretches = graph_.CutChain(chain, interiors);
      result_.stretches.insert(result_.stretches.end(), stretches.begin(), stretches.end());
    }
    std::sort(replaced.rbegin(), replaced.rend());
    for (const int k : replaced) problem.factors.erase(problem.factors.begin() + k);
    for (const Stretch<G>& stretch : result_.stretches) {
      Factor<G> factor;
      factor.term = &stretch.term;
      factor.convention = kCoarseConvention;
      factor.i = index_of(stretch.node[0]);
      factor.j = index_of(stretch.node[1]);
      problem.factors.push_back(factor);
    }
    result_.indices.clear();
    for (const Index n : nodes_) result_.indices.push_back(index_of(n));
  }

  const std::vector<Index>& nodes_;
  CondensedGraph<G>& graph_;
  Neighborhood<G>& result_;
};

}  // namespace

template <typename G>
Status FindNeighborhood(const std::vector<Index>& nodes, int max_nodes, CondensedGraph<G>* graph,
                        Neighborhood<G>* neighborhood) {
  return NeighborhoodBuilder<G>(nodes, graph, neighborhood).Build(max_nodes);
}

template Status FindNeighborhood(const std::vector<Index>&, int, CondensedGraph<SE2>*,
                                 Neighborhood<SE2>*);
template Status FindNeighborhood(const std::vector<Index>&, int, CondensedGraph<SE3>*,
                                 Neighborhood<SE3>*);
template Status FindNeighborhood(const std::vector<Index>&, int, CondensedGraph<YawPose>*,
                                 Neighborhood<YawPose>*);

}  // namespace hpgo
