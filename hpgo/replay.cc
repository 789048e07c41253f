#include "hpgo/replay.h"

#include <algorithm>

#include "hpgo/graph/edge_classes.h"

namespace hpgo {

template <typename G>
std::vector<ReplayStep> ReplaySteps(const PoseGraph<G>& graph) {
  const std::vector<int> order = IdOrder(graph);
  std::vector<int> rank(order.size());
  for (int r = 0; r < static_cast<int>(order.size()); ++r) rank[order[r]] = r;
  std::vector<ReplayStep> steps(order.size());
  for (std::size_t r = 0; r < order.size(); ++r) steps[r].node = order[r];
  const std::vector<bool> closures = LoopClosures(graph);
  for (int k = 0; k < static_cast<int>(graph.edges().size()); ++k) {
    const GraphEdge<G>& edge = graph.edges()[k];
    ReplayStep& step = steps[std::max(rank[edge.i], rank[edge.j])];
    step.edges.push_back(k);
    step.num_odometry += !closures[k];
  }
  for (int k = 0; k < static_cast<int>(graph.priors().size()); ++k) {
    steps[rank[graph.priors()[k].node]].priors.push_back(k);
  }
  for (ReplayStep& step : steps) {
    std::stable_sort(step.edges.begin(), step.edges.end(),
                     [&](int a, int b) { return closures[a] < closures[b]; });
  }
  return steps;
}

template <typename G>
Result<G> StartPose(const PoseGraph<G>& graph, const ReplayStep& step,
                    const PoseOfNode<G>& pose_of) {
  const GraphNode<G>& node = graph.nodes()[step.node];
  if (!node.fixed && !step.edges.empty()) {
    const GraphEdge<G>& edge = graph.edges()[step.edges.front()];
    const bool forward = edge.j == step.node;
    const Result<G> neighbour = pose_of(forward ? edge.i : edge.j);
    if (!neighbour.ok()) return neighbour.status();
    return *neighbour * (forward ? edge.measurement : edge.measurement.Inverse());
  }
  if (!node.fixed && !node.has_pose && !step.priors.empty()) {
    const GraphPrior<G>& prior = graph.priors()[step.priors.front()];
    return prior.measurement * prior.offset.Inverse();
  }
  return node.has_pose ? node.pose : G();
}

template <typename G>
Status AddStep(const PoseGraph<G>& graph, const ReplayStep& step, const G& pose,
               const typename Optimizer<G>::Loss& closure_loss, Optimizer<G>* optimizer) {
  const GraphNode<G>& node = graph.nodes()[step.node];
  const auto id = [&](int index) { return graph.nodes()[index].id; };
  Status status = optimizer->AddNode(node.id, pose);
  if (status.ok() && node.fixed) status = optimizer->SetFixed(node.id, true);
  for (int e = 0; e < static_cast<int>(step.edges.size()); ++e) {
    if (!status.ok()) return status;
    const GraphEdge<G>& edge = graph.edges()[step.edges[e]];
    status = optimizer
                 ->AddEdge(id(edge.i), id(edge.j), edge.measurement, edge.information,
                           e < step.num_odometry ? nullptr : closure_loss)
                 .status();
  }
  for (const int k : step.priors) {
    if (!status.ok()) return status;
    const GraphPrior<G>& prior = graph.priors()[k];
    status =
        optimizer->AddPrior(node.id, prior.measurement, prior.information, prior.offset).status();
  }
  return status;
}

template <typename G>
Status ApplyStep(const PoseGraph<G>& graph, const ReplayStep& step,
                 const typename Optimizer<G>::Loss& closure_loss, Optimizer<G>* optimizer) {
  const Result<G> pose = StartPose<G>(
      graph, step, [&](int node) { return optimizer->GetPose(graph.nodes()[node].id); });
  if (!pose.ok()) return pose.status();
  return AddStep<G>(graph, step, *pose, closure_loss, optimizer);
}

template std::vector<ReplayStep> ReplaySteps(const PoseGraph<SE2>&);
template std::vector<ReplayStep> ReplaySteps(const PoseGraph<SE3>&);
template std::vector<ReplayStep> ReplaySteps(const PoseGraph<YawPose>&);
template Result<SE2> StartPose(const PoseGraph<SE2>&, const ReplayStep&, const PoseOfNode<SE2>&);
template Result<SE3> StartPose(const PoseGraph<SE3>&, const ReplayStep&, const PoseOfNode<SE3>&);
template Result<YawPose> StartPose(const PoseGraph<YawPose>&, const ReplayStep&,
                                   const PoseOfNode<YawPose>&);
template Status AddStep(const PoseGraph<SE2>&, const ReplayStep&, const SE2&,
                        const Optimizer<SE2>::Loss&, Optimizer<SE2>*);
template Status AddStep(const PoseGraph<SE3>&, const ReplayStep&, const SE3&,
                        const Optimizer<SE3>::Loss&, Optimizer<SE3>*);
template Status AddStep(const PoseGraph<YawPose>&, const ReplayStep&, const YawPose&,
                        const Optimizer<YawPose>::Loss&, Optimizer<YawPose>*);
template Status ApplyStep(const PoseGraph<SE2>&, const ReplayStep&, const Optimizer<SE2>::Loss&,
                          Optimizer<SE2>*);
template Status ApplyStep(const PoseGraph<SE3>&, const ReplayStep&, const Optimizer<SE3>::Loss&,
                          Optimizer<SE3>*);
template Status ApplyStep(const PoseGraph<YawPose>&, const ReplayStep&,
                          const Optimizer<YawPose>::Loss&, Optimizer<YawPose>*);

}  // namespace hpgo
