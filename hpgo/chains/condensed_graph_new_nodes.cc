// The condensed graph: nodes that are new, where they are posed and which begin a component.

#include <algorithm>
#include <map>
#include <numeric>

#include "ceres_costs/factor_term.h"
#include "hpgo/chains/condensed_graph.h"

namespace hpgo {

// The touched nodes that are in no place yet.
template <typename G>
std::vector<Index> CondensedGraph<G>::LooseByAge() const {
  std::vector<Index> loose;
  for (const Index n : touched_) {
    if (nodes_[n].alive && nodes_[n].loose) loose.push_back(n);
  }
  std::sort(loose.begin(), loose.end(),
            [&](Index a, Index b) { return nodes_[a].born < nodes_[b].born; });
  return loose;
}

// The caller may have posed new nodes in another estimate of the map than the current one. Each
// takes, of its own pose and those by its oldest edges (what an edge to an older node says, what
// its new neighbour was moved by), the one at which its edges cost least.
template <typename G>
void CondensedGraph<G>::PoseNewNodes(const std::vector<Index>& loose) {
  // A node that closes a loop may jump: the chain behind it takes that up. Several among new nodes
  // would contradict each other, and tear their trajectory.
  int closing = 0;
  for (const Index n : loose) {
    bool old = false, follows = false;
    ForEachEdgeOf(n, [&](Index, Index other) {
      if (other == kNone) return;
      old |= nodes_[other].born < first_new_;
      follows |= nodes_[other].born >= first_new_ && nodes_[other].born < nodes_[n].born;
    });
    closing += old && follows;
  }
  std::map<Index, G> given;  // by new node with its pose found
  for (const Index n : loose) {
    G& pose = loose_.at(n);
    given.emplace(n, pose);
    struct Tie {
      Index edge, other;
      G X;  // T_world_other
      bool old;
    };
    std::vector<Tie> ties;
    ForEachEdgeOf(n, [&](Index e, Index other) {
      if (other == kNone) return;
      const bool old = nodes_[other].born < first_new_;  // a new one that is held is not loose
      if (old || !nodes_[other].loose || given.count(other) > 0)
        ties.push_back({e, other, WorldPose(other), old});
    });
    if (ties.empty()) continue;
    const auto cost = [&](const G& X) {
      double sum = 0;
      for (const Tie& tie : ties) {
        const bool forward = edges_[tie.edge].node[1] == n;
        sum += FactorCost(FactorOf(tie.edge), false, forward ? tie.X.Between(X) : X.Between(tie.X));
      }
      return sum;
    };
    std::vector<G> candidates;
    for (auto tie = ties.rbegin(); tie != ties.rend() && candidates.size() < 2; ++tie) {
      if (tie->old) {
        const G& Z = FactorOf(tie->edge).term->measurement;
        candidates.push_back(tie->X * (edges_[tie->edge].node[1] == n ? Z : Z.Inverse()));
      } else if (given.count(tie->other) > 0) {
        candidates.push_back(tie->X * given.at(tie->other).Between(given.at(n)));
        if (closing > 1) break;
      }
    }
    double least = cost(pose);
    for (const G& candidate : candidates) {
      const double at = cost(candidate);
      if (!(at < least)) continue;
      least = at;
      pose = candidate.Normalized();
    }
  }
}

// Components of new nodes alone, which come by age: the first node of each is kept.
template <typename G>
void CondensedGraph<G>::FindRoots(const std::vector<Index>& fresh) {
  std::map<Index, int> rank;
  for (const Index n : fresh) rank.emplace(n, static_cast<int>(rank.size()));
  if (fresh.empty()) return;
  std::vector<int> up(fresh.size());
  std::iota(up.begin(), up.end(), 0);
  const auto find = [&](int k) {
    while (up[k] != k) k = up[k] = up[up[k]];
    return k;
  };
  std::vector<bool> tied(fresh.size(), false), held(fresh.size(), false);
  const auto unite = [&](int a, int b) {
    a = find(a);
    b = find(b);
    const int first = std::min(a, b), second = std::max(a, b);
    tied[first] = tied[first] || tied[second];
    held[first] = held[first] || held[second];
    up[second] = first;
  };
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    held[find(static_cast<int>(k))] = held[find(static_cast<int>(k))] || nodes_[fresh[k]].held;
    ForEachEdgeOf(fresh[k], [&](Index, Index other) {
      const int own = find(static_cast<int>(k));
      if (other == kNone) {
        held[own] = true;
      } else if (const auto it = rank.find(other); it != rank.end()) {
        unite(own, it->second);
      } else {
        tied[own] = true;
      }
    });
  }
  const bool nothing_yet = hierarchy_.level(0).num_nodes == 0;
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    if (up[k] != static_cast<int>(k) || tied[k]) continue;
    // The first node of all is where the map begins.
    const bool alone = nodes_[fresh[k]].degree == 0 && !(nothing_yet && k == 0);
    has_new_component_ |= !alone || !condense_;
    if (held[k] || alone) continue;
    nodes_[fresh[k]].root = true;
    roots_.push_back(fresh[k]);
  }
}

template class CondensedGraph<ceres_costs::SE2>;
template class CondensedGraph<ceres_costs::SE3>;
template class CondensedGraph<ceres_costs::YawPose>;

}  // namespace hpgo
