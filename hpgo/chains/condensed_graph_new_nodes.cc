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

// m; the path from the last kept node to the end of a chain that hangs free, 0 elsewhere.
template <typename G>
double CondensedGraph<G>::LengthOfFreeEnd(Index n) const {
  const Index c = ChainOfNode(n);
  if (c == kNone) return 0;
  const Chain& chain = chains_[c];
  return chain.node[0] == n || chain.node[1] == n ? chain.length : 0;
}

// The caller may have posed new nodes in another estimate of the map than the current one. Each
// takes, of its own pose and those by its oldest edges (what an edge to an older node says, what
// its new neighbour was moved by), the one at which its edges cost least. So one that closes a loop
// jumps, and the chain by which it follows its youngest neighbour takes that up; but no further
// than that can bend at once: elsewhere it would tear.
template <typename G>
void CondensedGraph<G>::PoseNewNodes(const std::vector<Index>& loose) {
  constexpr int kMostTried = 2;
  struct Posed {
    G given;
    double behind;  // m; the path to the last node that may be kept
  };
  std::map<Index, Posed> posed;
  for (const Index n : loose) {
    G& pose = loose_.at(n);
    struct Tie {
      Index edge, other;
      G X;     // T_world_other
      G pose;  // of n, that it says
    };
    std::vector<Tie> ties;
    ForEachEdgeOf(n, [&](Index e, Index other) {
      if (other == kNone) return;
      const G X = WorldPose(other);
      if (const auto it = posed.find(other); it != posed.end()) {
        ties.push_back({e, other, X, X * it->second.given.Between(pose)});
      } else if (nodes_[other].born < first_new_) {
        const G& Z = FactorOf(e).term->measurement;
        ties.push_back({e, other, X, X * (edges_[e].node[1] == n ? Z : Z.Inverse())});
      } else if (!nodes_[other].loose) {  // held
        ties.push_back({e, other, X, pose});
      }
    });
    const G given = pose;
    if (ties.empty()) {
      posed.insert({n, {given, 0}});
      continue;
    }
    const Tie& followed = *std::max_element(
        ties.begin(), ties.end(),
        [&](const Tie& a, const Tie& b) { return nodes_[a.other].born < nodes_[b.other].born; });
    const auto it = posed.find(followed.other);
    const double length = it != posed.end() ? it->second.behind : LengthOfFreeEnd(followed.other);
    SpanModel<G> behind;
    behind.T = followed.pose;
    behind.length =
        static_cast<float>(length + followed.X.Between(followed.pose).translation().norm());
    const auto is_within_reach = [&](const G& X) {
      return BendAt(behind, X) <= kReachOfNewNode || !MeasuresAll(*FactorOf(followed.edge).term);
    };
    const auto cost = [&](const G& X) {
      double sum = 0;
      for (const Tie& tie : ties) {
        const bool forward = edges_[tie.edge].node[1] == n;
        sum += FactorCost(FactorOf(tie.edge), false, forward ? tie.X.Between(X) : X.Between(tie.X));
      }
      return sum;
    };
    if (!is_within_reach(pose)) pose = followed.pose;
    double least = cost(pose);
    int tried = 0;
    for (auto tie = ties.rbegin(); tie != ties.rend() && tried < kMostTried; ++tie, ++tried) {
      if (!is_within_reach(tie->pose)) continue;
      const double at = cost(tie->pose);
      if (!(at < least)) continue;
      least = at;
      pose = tie->pose.Normalized();
    }
    posed.insert({n, {given, ties.size() == 1 ? behind.length : 0}});
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
