#include "hpgo/graph/upright.h"

#include <cmath>
#include <string>
#include <utility>

#include "hpgo/graph/validate.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;

// The rotation about z that is nearest: rotation = Rz(yaw) * tilt, the tilt of the least angle.
double YawOf(const Eigen::Quaterniond& rotation) {
  return ceres_costs::NormalizeAngle(2 * std::atan2(rotation.z(), rotation.w()));
}

// Of an error e(D), D = C * Exp(d) in the measured frame, as one of a deviation Exp(u) between
// upright frames: d = Ad(B^-1) u of the rotation B, and C turns upright axes into measured ones.
YawPose::Matrix UprightInformation(const SE3::Matrix& information, ErrorConvention convention,
                                   const Eigen::Matrix3d& upright_in_measured,
                                   const Eigen::Matrix3d& B) {
  // Half the angle is what a quaternion's vector part holds.
  const double scale = convention == ErrorConvention::kG2o ? 0.5 : 1;
  Eigen::Matrix<double, 6, 4> J = Eigen::Matrix<double, 6, 4>::Zero();
  J.topLeftCorner<3, 3>() = upright_in_measured;
  J.bottomRightCorner<3, 1>() = scale * B.row(2).transpose();
  const YawPose::Matrix result = J.transpose() * information * J;
  return 0.5 * (result + result.transpose());
}

// Where `rotation` is what is measured of Rz(yaw) * B.
template <typename Measured>
void SetUpright(const Eigen::Vector3d& t, const Eigen::Quaterniond& rotation,
                const Eigen::Quaterniond& measured_frame, const Eigen::Quaterniond& B,
                const SE3::Matrix& information, ErrorConvention convention, Measured* out) {
  out->measurement = YawPose(t(0), t(1), t(2), YawOf(rotation * B.conjugate()));
  out->information =
      UprightInformation(information, convention,
                         measured_frame.toRotationMatrix().transpose() * out->measurement.matrix(),
                         B.toRotationMatrix());
}

}  // namespace

SE3 UprightGraph::Tilted(int node, const YawPose& pose) const {
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(pose.angle(), Eigen::Vector3d::UnitZ()));
  return SE3(pose.translation(), yaw * tilts[node]).Normalized();
}

Result<UprightGraph> MakeUpright(const PoseGraph<SE3>& graph, ErrorConvention convention) {
  UprightGraph result;
  result.graph.Reserve(graph.nodes().size(), graph.edges().size());
  for (const GraphNode<SE3>& node : graph.nodes()) {
    const std::string name = "node " + std::to_string(node.id);
    if (!node.has_pose) {
      return Status(StatusCode::kInvalidArgument, name +
                                                      " has no pose that its roll and pitch "
                                                      "could be taken from");
    }
    const Status status = CheckPose(node.pose, name + ": the pose");
    if (!status.ok()) return status;
    const SE3 pose = node.pose.Normalized();
    const Eigen::Quaterniond rotation = pose.rotation();
    const double yaw = YawOf(rotation);
    GraphNode<YawPose> upright;
    upright.id = node.id;
    upright.fixed = node.fixed;
    upright.pose =
        YawPose(pose.translation()(0), pose.translation()(1), pose.translation()(2), yaw);
    const Result<int> added = result.graph.AddNode(upright);
    if (!added.ok()) return added.status();
    result.tilts.push_back(Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ()) * rotation);
  }
  for (const GraphEdge<SE3>& edge : graph.edges()) {
    const SE3 Z = edge.measurement.Normalized();
    const Eigen::Quaterniond& A_i = result.tilts[edge.i];
    const Eigen::Quaterniond turned = A_i * Z.rotation();
    GraphEdge<YawPose> upright;
    upright.i = edge.i;
    upright.j = edge.j;
    SetUpright(A_i * Z.translation(), turned, turned, result.tilts[edge.j], edge.information,
               convention, &upright);
    const Status status = result.graph.AddEdge(upright);
    if (!status.ok()) return status;
  }
  for (const GraphPrior<SE3>& prior : graph.priors()) {
    const SE3 Z = prior.measurement.Normalized(), P = prior.offset.Normalized();
    const Eigen::Quaterniond& A = result.tilts[prior.node];
    const Eigen::Vector3d lever = A * P.translation();
    GraphPrior<YawPose> upright;
    upright.node = prior.node;
    upright.offset = YawPose(lever(0), lever(1), lever(2), 0);
    SetUpright(Z.translation(), Z.rotation(), Z.rotation(), A * P.rotation(), prior.information,
               convention, &upright);
    const Status status = result.graph.AddPrior(upright);
    if (!status.ok()) return status;
  }
  return result;
}

}  // namespace hpgo
