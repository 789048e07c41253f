// The scan solver of karto's mapper, and so of slam_toolbox, over the optimizer.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "Eigen/LU"
#include "hpgo/live/pose_map.h"
#include "hpgo/optimizer.h"

namespace hpgo {

// A `Base` (karto::ScanSolver) to hand to the mapper. `Vertex` and `Edge` are karto's, of its range
// scans; `LinkInfo` is the label of an edge; Pose2 has GetX, GetY, GetHeading and their setters.
//
//   using Solver = hpgo::KartoScanSolver<karto::ScanSolver,
//                                        karto::Vertex<karto::LocalizedRangeScan>,
//                                        karto::Edge<karto::LocalizedRangeScan>,
//                                        karto::LinkInfo, karto::Pose2>;
//
// As the mapper calls it: AddNode, AddConstraint for each link; after a loop closure Compute,
// GetCorrections, Clear. Corrections are the scans that have moved since they were last taken,
// which is when Clear is called: what a Compute has moved is not lost if the corrections of another
// are never looked at. After a failed Compute there are none, and the estimate is the last good
// one. All calls may come from any thread; getGraph and GetNodeOrientation wait for no Compute.
template <typename Base, typename Vertex, typename Edge, typename LinkInfo, typename Pose2>
class KartoScanSolver : public Base {
 public:
  using Corrections = std::vector<std::pair<std::int32_t, Pose2>>;

  KartoScanSolver() { Empty(); }

  // `loss` of every link, null: squared. A scan is returned once it has moved by more than
  // `distance` (m) or `angle` (rad). Empties the graph. kInvalidArgument for options out of range.
  Status SetOptions(const OptimizerOptions& options, Optimizer2d::Loss loss, double distance,
                    double angle) {
    const Status status = options.Validate();
    if (!status.ok()) return status;
    const std::lock_guard<std::mutex> lock(mutex_);
    options_ = options;
    loss_ = std::move(loss);
    distance_ = distance;
    angle_ = angle;
    Empty();
    return Status::Ok();
  }

  // --- karto::ScanSolver.
  void AddNode(Vertex* vertex) override {
    if (vertex == nullptr) return;
    const auto* scan = vertex->GetObject();
    const Pose2 pose = scan->GetCorrectedPose();
    const NodeId id = scan->GetUniqueId();
    const SE2 at(pose.GetX(), pose.GetY(), pose.GetHeading());
    const std::lock_guard<std::mutex> lock(mutex_);
    last_status_ = optimizer_.AddNode(id, at);
    if (last_status_.ok()) Show(id, at);
  }

  void AddConstraint(Edge* edge) override {
    if (edge == nullptr) return;
    const NodeId i = edge->GetSource()->GetObject()->GetUniqueId();
    const NodeId j = edge->GetTarget()->GetObject()->GetUniqueId();
    // The label of a scan's edge is always a link.
    auto* link = static_cast<LinkInfo*>(edge->GetLabel());
    const Pose2 pose = link->GetPoseDifference();
    const auto& covariance = link->GetCovariance();
    Eigen::Matrix3d sigma;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) sigma(r, c) = covariance(r, c);
    }
    const Eigen::Matrix3d inverse = (0.5 * (sigma + sigma.transpose())).inverse();
    const Eigen::Matrix3d information = 0.5 * (inverse + inverse.transpose());
    const std::lock_guard<std::mutex> lock(mutex_);
    // The matcher's covariance is along the axes of the first scan.
    last_status_ = optimizer_
                       .AddEdge(i, j, SE2(pose.GetX(), pose.GetY(), pose.GetHeading()), information,
                                loss_, InfoFrame::kFirstNode)
                       .status();
  }

  void RemoveNode(std::int32_t id) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    last_status_ = optimizer_.RemoveNode(id).status();
    if (!last_status_.ok()) return;
    pending_.erase(id);
    corrections_.clear();
    shown_writer_.Erase(id);
    PublishShown();
  }

  void RemoveConstraint(std::int32_t source, std::int32_t target) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto gone = optimizer_.RemoveEdges(source, target);
    last_status_ = gone.status();
    if (gone.ok() && gone->empty()) {
      last_status_ =
          Status(StatusCode::kNotFound, "no link between the nodes " + std::to_string(source) +
                                            " and " + std::to_string(target));
    }
  }

  void Compute() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    corrections_.clear();
    const UpdateReport report = optimizer_.Converge();
    last_status_ = report.status;
    // What has moved stays to be returned until it is taken.
    const auto taken = optimizer_.TakeCorrections(distance_, angle_);
    for (const auto& [id, pose] : taken.moved) {
      pending_[static_cast<std::int32_t>(id)] = pose;
      shown_writer_.Set(id, pose);
    }
    PublishShown();
    if (!report.status.ok()) return;
    for (const auto& [id, pose] : pending_) {
      Pose2 corrected;
      corrected.SetX(pose.data()[0]);
      corrected.SetY(pose.data()[1]);
      corrected.SetHeading(pose.Normalized().angle());
      corrections_.emplace_back(id, corrected);
    }
  }

  const Corrections& GetCorrections() const override { return corrections_; }

  // The corrections have been taken.
  void Clear() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (corrections_.empty()) return;
    corrections_.clear();
    pending_.clear();
  }

  void Reset() override {
    const std::lock_guard<std::mutex> lock(mutex_);
    Empty();
  }

  // The poses by id: a copy of the calling thread's own, good until it next asks.
  std::unordered_map<int, Eigen::Vector3d>* getGraph() override {
    thread_local std::unordered_map<int, Eigen::Vector3d> graph;
    graph.clear();
    const PoseMap<SE2> poses = Shown();
    graph.reserve(poses.size());
    poses.ForEach([](NodeId id, const SE2& pose) {
      graph[static_cast<int>(id)] =
          Eigen::Vector3d(pose.data()[0], pose.data()[1], pose.Normalized().angle());
    });
    return &graph;
  }

  // Moves a node by hand: to x and y, and its heading further by the third entry.
  void ModifyNode(const int& id, Eigen::Vector3d pose) override {
    const std::lock_guard<std::mutex> lock(mutex_);
    const Result<SE2> old = optimizer_.GetPose(id);
    last_status_ = old.status();
    if (!old.ok()) return;
    const SE2 moved = SE2(pose(0), pose(1), old->angle() + pose(2)).Normalized();
    last_status_ = optimizer_.SetPose(id, moved);
    if (last_status_.ok()) Show(id, moved);
  }

  void GetNodeOrientation(const int& id, double& heading) override {
    const PoseMap<SE2> poses = Shown();
    const SE2* pose = poses.Find(id);
    if (pose != nullptr) heading = pose->Normalized().angle();
  }

  // --- For the plugin and for tests.
  // What became of the last call; names the node or link.
  Status last_status() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return last_status_;
  }
  // Runs `use` on the optimizer, while nothing else does.
  template <typename Use>
  void WithOptimizer(Use&& use) {
    const std::lock_guard<std::mutex> lock(mutex_);
    use(optimizer_);
  }

 private:
  void Empty() {
    optimizer_ = Optimizer2d(options_);
    optimizer_.TakeCorrections();  // from here on everything counts
    corrections_.clear();
    pending_.clear();
    last_status_ = Status::Ok();
    shown_writer_.Clear();
    PublishShown();
  }
  void Show(NodeId id, const SE2& pose) {
    pending_.erase(static_cast<std::int32_t>(id));
    shown_writer_.Set(id, pose);
    PublishShown();
  }
  void PublishShown() {
    PoseMap<SE2> poses = shown_writer_.Publish();
    const std::lock_guard<std::mutex> lock(shown_mutex_);
    std::swap(shown_, poses);  // the former version is freed behind the lock
  }
  PoseMap<SE2> Shown() const {
    const std::lock_guard<std::mutex> lock(shown_mutex_);
    return shown_;
  }

  mutable std::mutex mutex_;  // of the optimizer and the corrections; held while it solves
  OptimizerOptions options_;
  Optimizer2d::Loss loss_;
  double distance_ = 1e-6, angle_ = 1e-6;
  Optimizer2d optimizer_;
  Status last_status_;
  std::unordered_map<std::int32_t, SE2> pending_;  // moved, and not taken by the mapper yet
  Corrections corrections_;

  PoseMapWriter<SE2> shown_writer_;

  mutable std::mutex shown_mutex_;  // of the poses shown; held for moments only
  PoseMap<SE2> shown_;
};

}  // namespace hpgo
