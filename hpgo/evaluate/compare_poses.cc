#include "hpgo/evaluate/compare_poses.h"

#include <optional>
#include <string>

namespace hpgo {
namespace {

template <typename G>
Status CheckContained(const PoseGraph<G>& nodes, const PoseGraph<G>& other, const char* where) {
  for (const GraphNode<G>& node : nodes.nodes()) {
    if (!other.Find(node.id)) {
      return Status(StatusCode::kNotFound,
                    "node " + std::to_string(node.id) + " is not in the " + where);
    }
  }
  return Status::Ok();
}

template <typename G>
Result<TrajectoryError<G>> Compare(const PoseGraph<G>& graph, const PoseGraph<G>& reference,
                                   AlignmentMode mode) {
  if (Status status = CheckContained(graph, reference, "reference"); !status.ok()) return status;
  if (Status status = CheckContained(reference, graph, "graph compared"); !status.ok()) {
    return status;
  }
  std::vector<G> compared, truth;
  compared.reserve(reference.nodes().size());
  truth.reserve(reference.nodes().size());
  for (const GraphNode<G>& node : reference.nodes()) {
    compared.push_back(graph.nodes()[*graph.Find(node.id)].pose);
    truth.push_back(node.pose);
  }
  return AbsoluteTrajectoryError(compared, truth, mode);
}

}  // namespace

template <typename G>
Result<TrajectoryError<G>> ComparePosesUpToGauge(const PoseGraph<G>& graph,
                                                 const PoseGraph<G>& reference) {
  return Compare(graph, reference, AlignmentMode::kRigid);
}

template <typename G>
Result<TrajectoryError<G>> ComparePoses(const PoseGraph<G>& graph, const PoseGraph<G>& reference) {
  return Compare(graph, reference, AlignmentMode::kIdentity);
}

template Result<TrajectoryError<SE2>> ComparePosesUpToGauge(const PoseGraph<SE2>&,
                                                            const PoseGraph<SE2>&);
template Result<TrajectoryError<SE3>> ComparePosesUpToGauge(const PoseGraph<SE3>&,
                                                            const PoseGraph<SE3>&);
template Result<TrajectoryError<YawPose>> ComparePosesUpToGauge(const PoseGraph<YawPose>&,
                                                                const PoseGraph<YawPose>&);
template Result<TrajectoryError<SE2>> ComparePoses(const PoseGraph<SE2>&, const PoseGraph<SE2>&);
template Result<TrajectoryError<SE3>> ComparePoses(const PoseGraph<SE3>&, const PoseGraph<SE3>&);
template Result<TrajectoryError<YawPose>> ComparePoses(const PoseGraph<YawPose>&,
                                                       const PoseGraph<YawPose>&);

}  // namespace hpgo
