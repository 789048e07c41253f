#include "hpgo/graph/validate.h"

#include "ceres_costs/whitening.h"

namespace hpgo {
namespace {

// Relative to the largest entry: what rounding leaves of a symmetric matrix.
constexpr double kSymmetryTolerance = 1e-9;

template <int N>
std::string RangeProblem(const double* values) {
  const Eigen::Map<const Eigen::Matrix<double, N, 1>> v(values);
  if (!v.allFinite()) return "is not finite";
  return v.cwiseAbs().maxCoeff() > kLargestValue ? "is too large" : "";
}

Status Invalid(const std::string& what, const std::string& problem) {
  if (problem.empty()) return Status::Ok();
  return Status(StatusCode::kInvalidArgument, what + problem);
}

}  // namespace

std::string PoseProblem(const SE2& pose) { return RangeProblem<3>(pose.data()); }
std::string PoseProblem(const YawPose& pose) { return RangeProblem<4>(pose.data()); }

std::string PoseProblem(const SE3& pose) {
  std::string problem = RangeProblem<3>(pose.data());
  if (!problem.empty()) return problem;
  const double largest = pose.rotation().coeffs().cwiseAbs().maxCoeff();
  if (!pose.rotation().coeffs().allFinite()) return "is not finite";
  return largest < kZeroQuaternion ? "has a zero quaternion" : "";
}

template <int N>
std::string InformationProblem(const Eigen::Matrix<double, N, N>& information) {
  std::string problem = RangeProblem<N * N>(information.data());
  if (!problem.empty()) return "information " + problem;
  if ((information - information.transpose()).cwiseAbs().maxCoeff() >
      kSymmetryTolerance * information.cwiseAbs().maxCoeff()) {
    return "information is not symmetric";
  }
  return ceres_costs::InformationProblem<N>(information);
}

std::string EdgeName(NodeId i, NodeId j) {
  return "edge " + std::to_string(i) + " -> " + std::to_string(j);
}

std::string PriorName(NodeId id) { return "prior of node " + std::to_string(id); }

template <typename G>
Status CheckPose(const G& pose, const std::string& what) {
  return Invalid(what + " ", PoseProblem(pose));
}

template <typename G>
Status CheckMeasurement(const G& measurement, const typename G::Matrix& information,
                        const std::string& what) {
  const Status status = CheckPose(measurement, what + ": the measurement");
  return status.ok() ? Invalid(what + ": ", InformationProblem<G::kDof>(information)) : status;
}

template <typename G>
Status CheckGraph(const PoseGraph<G>& graph) {
  const auto id = [&](int index) { return graph.nodes()[index].id; };
  Status status;
  for (const GraphNode<G>& node : graph.nodes()) {
    if (!node.has_pose) continue;
    status = CheckPose(node.pose, "node " + std::to_string(node.id) + ": the pose");
    if (!status.ok()) return status;
  }
  for (const GraphEdge<G>& edge : graph.edges()) {
    status = CheckMeasurement(edge.measurement, edge.information, EdgeName(id(edge.i), id(edge.j)));
    if (!status.ok()) return status;
  }
  for (const GraphPrior<G>& prior : graph.priors()) {
    const std::string name = PriorName(id(prior.node));
    status = CheckMeasurement(prior.measurement, prior.information, name);
    if (status.ok()) status = CheckPose(prior.offset, name + ": the offset");
    if (!status.ok()) return status;
  }
  return status;
}

template std::string InformationProblem<2>(const Eigen::Matrix2d&);
template std::string InformationProblem<3>(const Eigen::Matrix3d&);
template std::string InformationProblem<4>(const Eigen::Matrix4d&);
template std::string InformationProblem<6>(const Eigen::Matrix<double, 6, 6>&);

#define HPGO_INSTANTIATE(G)                                                         \
  template Status CheckPose(const G&, const std::string&);                          \
  template Status CheckMeasurement(const G&, const G::Matrix&, const std::string&); \
  template Status CheckGraph(const PoseGraph<G>&);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
