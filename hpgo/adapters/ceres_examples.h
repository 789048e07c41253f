// The types of Ceres' pose graph examples over the optimizer: a map of poses and a vector of
// constraints.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "hpgo/optimizer.h"

namespace hpgo {

// How a client's poses become SE2 or SE3. Of Ceres' examples: a 2D pose has x, y, yaw_radians, a
// constraint x, y, yaw_radians, information; a 3D pose has p, q, and a constraint t_be,
// information.
template <typename Pose>
SE2 ToGroup(const Pose& pose, SE2*) {
  return SE2(pose.x, pose.y, pose.yaw_radians);
}
template <typename Pose>
SE3 ToGroup(const Pose& pose, SE3*) {
  return SE3(pose.p, pose.q.normalized());
}
template <typename Pose>
void FromGroup(const SE2& X, Pose* pose) {
  pose->x = X.data()[0];
  pose->y = X.data()[1];
  pose->yaw_radians = X.Normalized().angle();
}
template <typename Pose>
void FromGroup(const SE3& X, Pose* pose) {
  pose->p = X.translation();
  pose->q = X.rotation();
}
template <typename Constraint>
SE2 MeasurementOf(const Constraint& constraint, SE2*) {
  return SE2(constraint.x, constraint.y, constraint.yaw_radians);
}
template <typename Constraint>
SE3 MeasurementOf(const Constraint& constraint, SE3*) {
  return SE3(constraint.t_be.p, constraint.t_be.q.normalized());
}

// Keeps a graph in these types optimized. The first pose of the map is held, as in the examples.
//
//   hpgo::CeresExampleProblem<hpgo::SE3, ceres::examples::MapOfPoses,
//                             ceres::examples::VectorOfConstraints> problem;
//   problem.Solve(constraints, &poses);   // again whenever either has grown
//
// The information is taken as it is written (the examples whiten with L where it should be L'), and
// turned from the examples' errors, which are in the frame of the first pose and in 3D twice the
// vector part of the inverse quaternion, to those of the optimizer. Not synchronized.
template <typename G, typename MapOfPoses, typename VectorOfConstraints>
class CeresExampleProblem {
 public:
  explicit CeresExampleProblem(const OptimizerOptions& options = {}) : optimizer_(options) {}

  // Takes in the poses and constraints beyond those of the last call, optimizes and writes all
  // poses back. Where what was there has shrunk, it starts anew. A pose that the client has changed
  // since is moved. An error leaves the poses as they are.
  UpdateReport Solve(const VectorOfConstraints& constraints, MapOfPoses* poses,
                     const UpdateLimits& limits = {}) {
    UpdateReport report;
    report.status = TakeIn(constraints, *poses);
    if (!report.status.ok()) return Fail(report);
    report = optimizer_.Converge(limits);
    if (!report.status.ok()) return Fail(report);
    written_.clear();
    for (auto& [id, pose] : *poses) {
      const G X = *optimizer_.GetPose(id);
      FromGroup(X, &pose);
      written_.emplace_hint(written_.end(), id, pose);
    }
    return report;
  }

  const Optimizer<G>& optimizer() const { return optimizer_; }

 private:
  // With the examples' error e = B e_here, B' Omega B.
  static typename G::Matrix InMeasurementFrame(const G& Z, const typename G::Matrix& information) {
    typename G::Matrix B = G::Matrix::Identity();
    B.template topLeftCorner<G::kDim, G::kDim>() = Z.matrix();
    if constexpr (G::kDim == 3) B.template bottomRightCorner<3, 3>() = -2 * Z.matrix();
    const typename G::Matrix turned = B.transpose() * information * B;
    return 0.5 * (turned + turned.transpose());
  }

  UpdateReport Fail(const UpdateReport& report) {
    optimizer_.Clear();
    written_.clear();
    num_constraints_ = 0;
    return report;
  }

  static bool IsSame(const G& a, const G& b) {
    return std::equal(a.data(), a.data() + G::kParams, b.data());
  }

  Status TakeIn(const VectorOfConstraints& constraints, const MapOfPoses& poses) {
    bool shrunk = constraints.size() < num_constraints_;
    for (const auto& [id, pose] : written_) shrunk |= poses.count(id) == 0;
    if (shrunk) (void)Fail({});
    for (const auto& [id, pose] : poses) {
      const G X = ToGroup(pose, static_cast<G*>(nullptr));
      const auto it = written_.find(id);
      Status status;
      if (it == written_.end()) {
        status = optimizer_.AddNode(id, X);
      } else if (!IsSame(X, ToGroup(it->second, static_cast<G*>(nullptr)))) {
        status = optimizer_.SetPose(id, X);
      }
      if (!status.ok()) return status;
    }
    const auto first = poses.begin();
    if (first != poses.end()) {
      if (held_ != first->first && optimizer_.HasNode(held_))
        (void)optimizer_.SetFixed(held_, false);
      held_ = first->first;
      const Status status = optimizer_.SetFixed(held_, true);
      if (!status.ok()) return status;
    }
    for (; num_constraints_ < constraints.size(); ++num_constraints_) {
      const auto& constraint = constraints[num_constraints_];
      const G Z = MeasurementOf(constraint, static_cast<G*>(nullptr));
      const typename G::Matrix information = constraint.information;
      const Status status = optimizer_
                                .AddEdge(constraint.id_begin, constraint.id_end, Z,
                                         InMeasurementFrame(Z, information))
                                .status();
      if (!status.ok()) return status;
    }
    return Status::Ok();
  }

  Optimizer<G> optimizer_;
  MapOfPoses written_;  // as the client was last given them
  std::size_t num_constraints_ = 0;
  NodeId held_ = 0;
};

}  // namespace hpgo
