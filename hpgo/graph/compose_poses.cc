#include "hpgo/graph/compose_poses.h"

#include <deque>
#include <vector>

#include "hpgo/graph/edge_classes.h"

namespace hpgo {
namespace {

// The edges at every node, in one array.
struct Incidence {
  std::vector<int> begin;  // node -> its first place in `edges`; one more at the end
  std::vector<int> edges;
};

template <typename G>
Incidence EdgesOfNodes(const PoseGraph<G>& graph) {
  Incidence incidence;
  incidence.begin.assign(graph.nodes().size() + 1, 0);
  for (const GraphEdge<G>& edge : graph.edges()) {
    ++incidence.begin[edge.i + 1];
    ++incidence.begin[edge.j + 1];
  }
  for (std::size_t k = 1; k < incidence.begin.size(); ++k) {
    incidence.begin[k] += incidence.begin[k - 1];
  }
  std::vector<int> next = incidence.begin;
  incidence.edges.resize(2 * graph.edges().size());
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    incidence.edges[next[graph.edges()[k].i]++] = static_cast<int>(k);
    incidence.edges[next[graph.edges()[k].j]++] = static_cast<int>(k);
  }
  return incidence;
}

// A node with a pose, and one of its edges to go along.
struct Step {
  int from;
  int edge;
};

template <typename G>
class Composer {
 public:
  explicit Composer(PoseGraph<G>* graph)
      : graph_(graph), incidence_(EdgesOfNodes(*graph)), closures_(LoopClosures(*graph)) {}

  // Queues the edges of a node that has a pose.
  void Reach(int node) {
    for (int k = incidence_.begin[node]; k < incidence_.begin[node + 1]; ++k) {
      const int edge = incidence_.edges[k];
      (closures_[edge] ? by_closure_ : by_odometry_).push_back({node, edge});
    }
  }

  // Goes on until no edge leads to a node without a pose; returns how many got one.
  int Spread() {
    int composed = 0;
    while (!by_odometry_.empty() || !by_closure_.empty()) {
      std::deque<Step>& queue = by_odometry_.empty() ? by_closure_ : by_odometry_;
      const Step step = queue.front();
      queue.pop_front();
      composed += Take(step);
    }
    return composed;
  }

 private:
  bool Take(const Step& step) {
    const GraphEdge<G>& edge = graph_->edges()[step.edge];
    const bool forward = edge.i == step.from;
    const int to = forward ? edge.j : edge.i;
    GraphNode<G>& node = graph_->node(to);
    if (node.has_pose) return false;
    const G motion = forward ? edge.measurement : edge.measurement.Inverse();
    node.pose = (graph_->nodes()[step.from].pose * motion).Normalized();
    node.has_pose = true;
    Reach(to);
    return true;
  }

  PoseGraph<G>* const graph_;
  const Incidence incidence_;
  const std::vector<bool> closures_;
  std::deque<Step> by_odometry_, by_closure_;
};

}  // namespace

template <typename G>
int ComposeMissingPoses(PoseGraph<G>* graph) {
  Composer<G> composer(graph);
  const std::vector<int> order = IdOrder(*graph);
  for (const int node : order) {
    if (graph->nodes()[node].has_pose) composer.Reach(node);
  }
  int composed = composer.Spread();
  for (const int node : order) {
    if (graph->nodes()[node].has_pose) continue;
    graph->node(node).pose = G();
    graph->node(node).has_pose = true;
    composer.Reach(node);
    composed += 1 + composer.Spread();
  }
  return composed;
}

template int ComposeMissingPoses(PoseGraph<SE2>*);
template int ComposeMissingPoses(PoseGraph<SE3>*);
template int ComposeMissingPoses(PoseGraph<YawPose>*);

}  // namespace hpgo
