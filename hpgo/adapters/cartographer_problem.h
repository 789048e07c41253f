// The optimization problem of Cartographer's 2D and 3D pose graphs over the optimizer.
#pragma once

#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "ceres_costs/losses.h"
#include "hpgo/adapters/graph_sync.h"

namespace hpgo {

// The weights of Cartographer's OptimizationProblemOptions that its pose graph costs have.
struct CartographerWeights {
  double huber_scale = 1e1;
  double local_slam_pose_translation_weight = 1e5, local_slam_pose_rotation_weight = 1e5;
  double odometry_translation_weight = 1e5, odometry_rotation_weight = 1e5;
};

// The calls of OptimizationProblemInterface, on Cartographer's own types, which `Types` names:
//
//   NodeId, SubmapId                      trajectory_id, and node_index or submap_index
//   NodeSpec, SubmapSpec, Rigid           G is SE2 for Rigid2d, SE3 for Rigid3d
//   NodeMap, SubmapMap                    MapById of these
//   Constraint, TrajectoryState           of PoseGraphInterface
//   ImuData, OdometryData
//   static G Pose(const Rigid&)
//   static Rigid MakeRigid(const G&)
//   static G Measurement(const Constraint&)       zbar_ij, in the plane in 2D
//   static const Rigid& Global(const NodeSpec&)
//   static void SetGlobal(const Rigid&, NodeSpec*)
//   static G Local(const NodeSpec&)               of local SLAM
//   static auto Time(const NodeSpec&)             comparable; differences convert to double
//   static const Rigid& Global(const SubmapSpec&)
//   static void SetGlobal(const Rigid&, SubmapSpec*)
//   static SubmapSpec MakeSubmap(const Rigid& global_pose)
//   static auto Time(const OdometryData&)
//   static G Pose(const OdometryData&)
//
// The whole vector of constraints comes at every Solve and is compared by submap, node and tag, so
// that a Solve costs what has changed. Consecutive nodes of a trajectory that is not frozen are
// tied by local SLAM and, where there is any, by odometry. Huber's loss is on constraints between
// submaps. The first submap and frozen trajectories are held. What is not taken is refused by name,
// in status(): costs of landmarks, and in 3D those of the IMU and of fixed frames; then a Solve
// changes nothing. Not synchronized: Cartographer solves on one thread and copies.
template <typename G, typename Types>
class CartographerProblem {
 public:
  using NodeId = typename Types::NodeId;
  using SubmapId = typename Types::SubmapId;
  using NodeSpec = typename Types::NodeSpec;
  using Rigid = typename Types::Rigid;
  using Constraint = typename Types::Constraint;

  explicit CartographerProblem(const CartographerWeights& weights = {},
                               const OptimizerOptions& options = {})
      : weights_(weights), sync_(options) {
    std::unique_ptr<ceres::LossFunction> huber;
    std::string error;
    if (!ceres_costs::MakeLoss("huber", weights.huber_scale, &huber, &error)) Refuse(error);
    huber_ = std::move(huber);
  }

  void AddImuData(int /*trajectory_id*/, const typename Types::ImuData& /*data*/) {
    // The 2D problem has no such cost either.
    if (G::kDim == 3) Refuse("rotation and acceleration costs of the IMU are not taken");
  }
  void AddOdometryData(int trajectory_id, const typename Types::OdometryData& data) {
    odometry_[trajectory_id].insert_or_assign(Types::Time(data), Types::Pose(data));
  }
  template <typename FixedFramePoseData>
  void AddFixedFramePoseData(int /*trajectory_id*/, const FixedFramePoseData& /*data*/) {
    Refuse("costs of fixed frames are not taken");
  }
  void AddTrajectoryNode(int trajectory_id, const NodeSpec& node) {
    nodes_.Append(trajectory_id, node);
  }
  void InsertTrajectoryNode(const NodeId& id, const NodeSpec& node) { nodes_.Insert(id, node); }
  void TrimTrajectoryNode(const NodeId& id) { nodes_.Trim(id); }
  void AddSubmap(int trajectory_id, const Rigid& global_pose) {
    submaps_.Append(trajectory_id, Types::MakeSubmap(global_pose));
  }
  void InsertSubmap(const SubmapId& id, const Rigid& global_pose) {
    submaps_.Insert(id, Types::MakeSubmap(global_pose));
  }
  void TrimSubmap(const SubmapId& id) { submaps_.Trim(id); }
  // The optimizer needs a handful; a limit on them would only leave it short of the optimum.
  void SetMaxNumIterations(int /*iterations*/) {}

  template <typename LandmarkNodes>
  void Solve(const std::vector<Constraint>& constraints,
             const std::map<int, typename Types::TrajectoryState>& states,
             const LandmarkNodes& landmarks) {
    status_ = Status::Ok();
    if (!refused_.empty()) {
      status_ = Status(StatusCode::kInvalidArgument, refused_);
      return;
    }
    if (!landmarks.empty()) {
      status_ = Status(StatusCode::kInvalidArgument,
                       "costs of landmarks are not taken: " + landmarks.begin()->first);
      return;
    }
    if (nodes_.empty()) return;
    status_ = TakeIn(constraints, states);
    if (status_.ok()) status_ = sync_.optimizer().Converge().status;
    if (!status_.ok()) {
      sync_.Clear();
      return;
    }
    // Told back as they read them: Node compares with what the types hold.
    const auto tell = [this](std::int64_t key, const G& pose, auto* spec) {
      Types::SetGlobal(Types::MakeRigid(pose), spec);
      sync_.Told(key, Types::Pose(Types::Global(*spec)));
    };
    for (const auto& [key, pose] : sync_.optimizer().TakeCorrections().moved) {
      const int trajectory = static_cast<int>(key >> (kIndexBits + 1));
      const int index = static_cast<int>(key & ((std::int64_t{1} << kIndexBits) - 1));
      if (key >> kIndexBits & 1) {
        tell(key, pose, &submaps_.at(SubmapId{trajectory, index}));
      } else {
        tell(key, pose, &nodes_.at(NodeId{trajectory, index}));
      }
    }
  }

  const typename Types::NodeMap& node_data() const { return nodes_; }
  const typename Types::SubmapMap& submap_data() const { return submaps_; }
  // Of the last Solve.
  const Status& status() const { return status_; }
  const Optimizer<G>& optimizer() const { return sync_.optimizer(); }

 private:
  static constexpr int kIndexBits = 32;
  enum Kind { kConstraint, kLocalSlam, kOdometry };
  // What it is; the ends; a tag.
  using Key = std::tuple<int, std::int64_t, std::int64_t, int>;
  using Sync = GraphSync<G, Key>;

  static std::int64_t KeyOf(const NodeId& id) {
    return std::int64_t{id.trajectory_id} << (kIndexBits + 1) | id.node_index;
  }
  static std::int64_t KeyOf(const SubmapId& id) {
    return std::int64_t{id.trajectory_id} << (kIndexBits + 1) | std::int64_t{1} << kIndexBits |
           id.submap_index;
  }

  void Refuse(const std::string& why) { refused_ = why; }

  static typename G::Matrix Information(double translation_weight, double rotation_weight) {
    typename G::Tangent diagonal;
    diagonal.template head<G::kDim>().setConstant(translation_weight * translation_weight);
    // Cartographer's 3D error is the rotation vector, twice the quaternion's.
    const double scale = G::kDim == 3 ? 4 : 1;
    diagonal.template tail<G::kRotationDof>().setConstant(scale * rotation_weight *
                                                          rotation_weight);
    return diagonal.asDiagonal();
  }

  Status TakeIn(const std::vector<Constraint>& constraints,
                const std::map<int, typename Types::TrajectoryState>& states) {
    const auto is_frozen = [&](int trajectory) {
      const auto it = states.find(trajectory);
      return it != states.end() && it->second == Types::TrajectoryState::FROZEN;
    };
    sync_.Begin();
    bool first = true;
    for (const auto& submap : submaps_) {
      const bool held = first || is_frozen(submap.id.trajectory_id);
      const Status status =
          sync_.Node(KeyOf(submap.id), Types::Pose(Types::Global(submap.data)), held);
      if (!status.ok()) return status;
      first = false;
    }
    for (const auto& node : nodes_) {
      const Status status = sync_.Node(KeyOf(node.id), Types::Pose(Types::Global(node.data)),
                                       is_frozen(node.id.trajectory_id));
      if (!status.ok()) return status;
    }
    for (const Constraint& constraint : constraints) {
      typename Sync::Edge edge;
      edge.i = KeyOf(constraint.submap_id);
      edge.j = KeyOf(constraint.node_id);
      edge.measurement = Types::Measurement(constraint);
      edge.information =
          Information(constraint.pose.translation_weight, constraint.pose.rotation_weight);
      if (constraint.tag == Constraint::INTER_SUBMAP) edge.loss = huber_;
      const Status status = sync_.AddEdge({kConstraint, edge.i, edge.j, constraint.tag}, edge);
      if (!status.ok()) return status;
    }
    const Status status = TieNodes(is_frozen);
    return status.ok() ? sync_.End() : status;
  }

  // Consecutive nodes, by local SLAM and by odometry.
  template <typename IsFrozen>
  Status TieNodes(const IsFrozen& is_frozen) {
    for (auto it = nodes_.begin(); it != nodes_.end(); ++it) {
      const auto next = std::next(it);
      if (next == nodes_.end()) break;
      const auto first = *it, second = *next;
      if (first.id.trajectory_id != second.id.trajectory_id ||
          second.id.node_index != first.id.node_index + 1 || is_frozen(first.id.trajectory_id)) {
        continue;
      }
      typename Sync::Edge edge;
      edge.i = KeyOf(first.id);
      edge.j = KeyOf(second.id);
      edge.measurement = Types::Local(first.data).Between(Types::Local(second.data));
      edge.information = Information(weights_.local_slam_pose_translation_weight,
                                     weights_.local_slam_pose_rotation_weight);
      Status status = sync_.AddEdge({kLocalSlam, edge.i, edge.j, 0}, edge);
      const auto from = OdometryAt(first.id.trajectory_id, Types::Time(first.data));
      const auto to = OdometryAt(first.id.trajectory_id, Types::Time(second.data));
      if (status.ok() && from && to) {
        edge.measurement = from->Between(*to);
        edge.information =
            Information(weights_.odometry_translation_weight, weights_.odometry_rotation_weight);
        status = sync_.AddEdge({kOdometry, edge.i, edge.j, 0}, edge);
      }
      if (!status.ok()) return status;
    }
    return Status::Ok();
  }

  // Between the two measurements around a time; none beyond them.
  template <typename T>
  std::optional<G> OdometryAt(int trajectory, const T& time) const {
    const auto data = odometry_.find(trajectory);
    if (data == odometry_.end()) return std::nullopt;
    const auto after = data->second.lower_bound(time);
    if (after == data->second.end()) return std::nullopt;
    if (after->first == time) return after->second;
    if (after == data->second.begin()) return std::nullopt;
    const auto before = std::prev(after);
    const double share = static_cast<double>(time - before->first) /
                         static_cast<double>(after->first - before->first);
    return before->second.Retract(share * before->second.LocalCoordinates(after->second));
  }

  using TimeType = decltype(Types::Time(std::declval<const NodeSpec&>()));

  const CartographerWeights weights_;
  typename Optimizer<G>::Loss huber_;
  GraphSync<G, Key> sync_;
  typename Types::NodeMap nodes_;
  typename Types::SubmapMap submaps_;
  std::map<int, std::map<TimeType, G>> odometry_;
  std::string refused_;
  Status status_;
};

}  // namespace hpgo
