#include "hpgo/io/trajectory.h"

#include <cmath>

#include "ceres_costs/finite.h"
#include "hpgo/graph/compose_poses.h"
#include "hpgo/graph/edge_classes.h"
#include "hpgo/io/line_fields.h"
#include "hpgo/io/output_file.h"

namespace hpgo {
namespace {

Status Invalid(const std::string& what) { return Status(StatusCode::kInvalidArgument, what); }

Status CheckWritable(const Trajectory& trajectory, TrajectoryFormat format) {
  const std::size_t size = trajectory.poses.size();
  if (format != TrajectoryFormat::kKitti && format != TrajectoryFormat::kTum) {
    return Invalid("a trajectory is written as KITTI or TUM");
  }
  if (!trajectory.stamps.empty() && trajectory.stamps.size() != size) {
    return Invalid(std::to_string(trajectory.stamps.size()) + " stamps for " +
                   std::to_string(size) + " poses");
  }
  if (!trajectory.ids.empty() && trajectory.ids.size() != size) {
    return Invalid(std::to_string(trajectory.ids.size()) + " ids for " + std::to_string(size) +
                   " poses");
  }
  for (std::size_t k = 0; k < size; ++k) {
    const bool stamp_is_finite = trajectory.stamps.empty() || std::isfinite(trajectory.stamps[k]);
    if (!stamp_is_finite || !IsFinite(trajectory.poses[k]))
      return Invalid("pose " + std::to_string(k) + " is not finite");
  }
  return Status::Ok();
}

void AppendKitti(const SE3& pose, std::string* text) {
  const Eigen::Matrix3d R = pose.matrix();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      AppendNumber(R(r, c), text);
      *text += ' ';
    }
    AppendNumber(pose.translation()(r), text);
    *text += r < 2 ? ' ' : '\n';
  }
}

void AppendTum(const Trajectory& trajectory, std::size_t k, std::string* text) {
  if (!trajectory.stamps.empty()) {
    AppendNumber(trajectory.stamps[k], text);
  } else {
    AppendNumber(trajectory.ids.empty() ? static_cast<std::int64_t>(k) : trajectory.ids[k], text);
  }
  for (int p = 0; p < SE3::kParams; ++p) {
    *text += ' ';
    AppendNumber(trajectory.poses[k].data()[p], text);
  }
  *text += '\n';
}

void AppendPose(const Trajectory& trajectory, std::size_t k, TrajectoryFormat format,
                std::string* text) {
  if (format == TrajectoryFormat::kKitti) {
    AppendKitti(trajectory.poses[k], text);
  } else {
    AppendTum(trajectory, k, text);
  }
}

}  // namespace

SE3 ToSpace(const SE2& pose) {
  return SE3(Eigen::Vector3d(pose.data()[0], pose.data()[1], 0),
             Eigen::Quaterniond(std::cos(pose.angle() / 2), 0, 0, std::sin(pose.angle() / 2)));
}

template <typename G>
Trajectory ToTrajectory(const PoseGraph<G>& graph) {
  PoseGraph<G> composed;
  const PoseGraph<G>* source = &graph;
  for (const GraphNode<G>& node : graph.nodes()) {
    if (node.has_pose) continue;
    composed = graph;
    ComposeMissingPoses(&composed);
    source = &composed;
    break;
  }
  Trajectory trajectory;
  for (const int node : IdOrder(*source)) {
    trajectory.poses.push_back(ToSpace(source->nodes()[node].pose));
    trajectory.ids.push_back(source->nodes()[node].id);
  }
  return trajectory;
}

Status WriteTrajectory(const Trajectory& trajectory, TrajectoryFormat format,
                       const std::string& path) {
  const Status writable = CheckWritable(trajectory, format);
  if (!writable.ok()) return writable;
  OutputFile out(path);
  for (std::size_t k = 0; k < trajectory.poses.size(); ++k) {
    AppendPose(trajectory, k, format, out.buffer());
    out.FlushIfLarge();
  }
  return out.Commit();
}

Status FormatTrajectory(const Trajectory& trajectory, TrajectoryFormat format, std::string* text) {
  const Status writable = CheckWritable(trajectory, format);
  if (!writable.ok()) return writable;
  for (std::size_t k = 0; k < trajectory.poses.size(); ++k) AppendPose(trajectory, k, format, text);
  return writable;
}

template Trajectory ToTrajectory(const PoseGraph<SE2>&);
template Trajectory ToTrajectory(const PoseGraph<SE3>&);

}  // namespace hpgo
