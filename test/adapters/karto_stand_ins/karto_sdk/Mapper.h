// Stand-ins with the names and the semantics of the parts of karto that a scan solver meets.
#pragma once

#include <cstdint>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "Eigen/Core"
#include "rclcpp/rclcpp.hpp"

namespace karto {

using kt_int32s = std::int32_t;

class Pose2 {
 public:
  Pose2() = default;
  Pose2(double x, double y, double heading) : x_(x), y_(y), heading_(heading) {}
  double GetX() const { return x_; }
  double GetY() const { return y_; }
  double GetHeading() const { return heading_; }
  void SetX(double x) { x_ = x; }
  void SetY(double y) { y_ = y; }
  void SetHeading(double heading) { heading_ = heading; }

 private:
  double x_ = 0, y_ = 0, heading_ = 0;
};

class Matrix3 {
 public:
  double& operator()(int row, int column) { return entries_[row][column]; }
  const double& operator()(int row, int column) const { return entries_[row][column]; }

 private:
  double entries_[3][3] = {};
};

class LocalizedRangeScan {
 public:
  LocalizedRangeScan(kt_int32s id, const Pose2& pose) : id_(id), pose_(pose) {}
  kt_int32s GetUniqueId() const { return id_; }
  const Pose2& GetCorrectedPose() const { return pose_; }
  void SetCorrectedPose(const Pose2& pose) { pose_ = pose; }

 private:
  kt_int32s id_;
  Pose2 pose_;
};

template <typename T>
class Vertex {
 public:
  explicit Vertex(T* object) : object_(object) {}
  T* GetObject() const { return object_; }

 private:
  T* object_;
};

class EdgeLabel {
 public:
  virtual ~EdgeLabel() = default;
};

class LinkInfo : public EdgeLabel {
 public:
  LinkInfo(const Pose2& difference, const Matrix3& covariance)
      : difference_(difference), covariance_(covariance) {}
  const Pose2& GetPoseDifference() { return difference_; }
  const Matrix3& GetCovariance() { return covariance_; }

 private:
  Pose2 difference_;
  Matrix3 covariance_;
};

template <typename T>
class Edge {
 public:
  Edge(Vertex<T>* source, Vertex<T>* target, std::unique_ptr<EdgeLabel> label)
      : source_(source), target_(target), label_(std::move(label)) {}
  Vertex<T>* GetSource() const { return source_; }
  Vertex<T>* GetTarget() const { return target_; }
  EdgeLabel* GetLabel() { return label_.get(); }

 private:
  Vertex<T>*source_, *target_;
  std::unique_ptr<EdgeLabel> label_;
};

class ScanSolver {
 public:
  using IdPoseVector = std::vector<std::pair<kt_int32s, Pose2>>;
  virtual ~ScanSolver() = default;
  virtual void Compute() = 0;
  virtual const IdPoseVector& GetCorrections() const = 0;
  virtual void AddNode(Vertex<LocalizedRangeScan>*) {}
  virtual void RemoveNode(kt_int32s) {}
  virtual void AddConstraint(Edge<LocalizedRangeScan>*) {}
  virtual void RemoveConstraint(kt_int32s, kt_int32s) {}
  virtual void Configure(rclcpp::Node::SharedPtr) {}
  virtual void Clear() {}
  virtual void Reset() {}
  virtual std::unordered_map<int, Eigen::Vector3d>* getGraph() { return nullptr; }
  virtual void ModifyNode(const int&, Eigen::Vector3d) {}
  virtual void GetNodeOrientation(const int&, double&) {}
};

}  // namespace karto
