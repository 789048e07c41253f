// RTAB-Map's graph optimizer: one call with the whole graph, from a graph that is kept.
#pragma once

#include <cmath>
#include <list>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "Eigen/Geometry"
#include "hpgo/adapters/graph_sync.h"

namespace hpgo {

// Takes the place of an rtabmap::Optimizer's optimize: `Transform` has x, y, z, getQuaterniond and
// a constructor of x, y, z, qx, qy, qz, qw; `Link` has from, to, type, transform, infMatrix and the
// types kPosePrior, kGravity. G is SE3, or SE2 where the optimizer is set to slam2d: then x, y, yaw
// and their information are taken.
//
// The call is stateless to its caller: the result is a function of what is given. Inside, the graph
// of the last call is kept and compared by content, so that a call costs what has changed since.
// The root is held at its pose; the other poses are a first guess, looked at for new nodes only. A
// link from a node to itself is a prior. Links of gravity are not taken: they are named in
// last_status(), and the result is empty, as it is after any failure. Not synchronized.
template <typename G, typename Transform, typename Link>
class RtabmapOptimizer {
 public:
  explicit RtabmapOptimizer(const OptimizerOptions& options = {}) : sync_(options) {}

  // `information_ignored`: every link weighs the same, as RTAB-Map's Optimizer/VarianceIgnored.
  void SetInformationIgnored(bool ignored) { information_ignored_ = ignored; }
  void SetLimits(const UpdateLimits& limits) { limits_ = limits; }

  // `intermediate` gets nothing: there are no iterations to be shown. `final_error` is the sum of
  // e' Omega e; `iterations` the number of solves.
  std::map<int, Transform> optimize(int root, const std::map<int, Transform>& poses,
                                    const std::multimap<int, Link>& links,
                                    std::list<std::map<int, Transform>>* intermediate = nullptr,
                                    double* final_error = nullptr, int* iterations = nullptr) {
    if (intermediate != nullptr) intermediate->clear();
    status_ = TakeIn(root, poses, links);
    UpdateReport report;
    if (status_.ok()) {
      report = sync_.optimizer().Converge(limits_);
      status_ = report.status;
    }
    if (!status_.ok()) {
      sync_.Clear();
      return {};
    }
    std::map<int, Transform> optimized;
    for (const auto& [id, pose] : poses) {
      if (id == root) {
        optimized.emplace_hint(optimized.end(), id, pose);
      } else {
        optimized.emplace_hint(optimized.end(), id,
                               FromGroup(*sync_.optimizer().GetPose(id), pose));
      }
    }
    if (final_error != nullptr) *final_error = sync_.optimizer().Cost();
    if (iterations != nullptr) *iterations = report.windows + report.top_solves;
    return optimized;
  }

  // Of the last call: names the node or link at fault.
  const Status& last_status() const { return status_; }
  const Optimizer<G>& optimizer() const { return sync_.optimizer(); }

 private:
  // From, to, type, and the how many-th of these.
  using Key = std::tuple<int, int, int, int>;

  static SE3 ToSE3(const Transform& T) {
    return SE3(Eigen::Vector3d(T.x(), T.y(), T.z()), T.getQuaterniond().normalized());
  }
  static G ToGroup(const Transform& T) {
    const SE3 X = ToSE3(T);
    if constexpr (G::kDim == 3) {
      return X;
    } else {
      const Eigen::Matrix3d R = X.matrix();
      return SE2(X.translation()(0), X.translation()(1), std::atan2(R(1, 0), R(0, 0)));
    }
  }
  // In 2D what the plane does not say stays as it was.
  static Transform FromGroup(const G& X, const Transform& given) {
    using Scalar = decltype(given.x());
    const auto make = [](const Eigen::Vector3d& t, const Eigen::Quaterniond& q) {
      return Transform(static_cast<Scalar>(t(0)), static_cast<Scalar>(t(1)),
                       static_cast<Scalar>(t(2)), static_cast<Scalar>(q.x()),
                       static_cast<Scalar>(q.y()), static_cast<Scalar>(q.z()),
                       static_cast<Scalar>(q.w()));
    };
    if constexpr (G::kDim == 3) {
      return make(X.translation(), X.rotation());
    } else {
      const double turn = X.angle() - ToGroup(given).angle();
      const Eigen::Quaterniond q =
          Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * given.getQuaterniond().normalized();
      return make(Eigen::Vector3d(X.data()[0], X.data()[1], given.z()), q);
    }
  }
  static typename G::Matrix InformationOf(const Link& link) {
    constexpr int kRows3d[] = {0, 1, 2, 3, 4, 5}, kRows2d[] = {0, 1, 5};
    const int* rows = G::kDim == 3 ? kRows3d : kRows2d;
    typename G::Matrix information;
    for (int r = 0; r < G::kDof; ++r) {
      for (int c = 0; c < G::kDof; ++c) {
        information(r, c) = link.infMatrix().template at<double>(rows[r], rows[c]);
      }
    }
    return information;
  }

  Status TakeIn(int root, const std::map<int, Transform>& poses,
                const std::multimap<int, Link>& links) {
    const auto root_pose = poses.find(root);
    if (root_pose == poses.end()) {
      return Status(StatusCode::kNotFound, "the root " + std::to_string(root) + " has no pose");
    }
    sync_.Begin();
    for (const auto& [id, pose] : poses) {
      const G* held = id == root ? nullptr : sync_.Given(id);
      const Status status = sync_.Node(id, held != nullptr ? *held : ToGroup(pose), id == root);
      if (!status.ok()) return status;
    }
    std::map<std::tuple<int, int, int>, int> count;
    for (const auto& [from, link] : links) {
      const auto refuse = [from = from, to = link.to()](const char* why) {
        return Status(StatusCode::kInvalidArgument,
                      "link " + std::to_string(from) + " -> " + std::to_string(to) + ": " + why);
      };
      if (link.type() == Link::kGravity) return refuse("gravity is not taken");
      if (link.from() == link.to() && link.type() != Link::kPosePrior) {
        return refuse("a self link that is no prior");
      }
      typename GraphSync<G, Key>::Edge edge;
      edge.i = link.from();
      edge.j = link.to();
      edge.measurement = ToGroup(link.transform());
      if (!information_ignored_) edge.information = InformationOf(link);
      const int type = static_cast<int>(link.type());
      const int index = count[{link.from(), link.to(), type}]++;
      const Status status = sync_.AddEdge({link.from(), link.to(), type, index}, edge);
      if (!status.ok()) return status;
    }
    return sync_.End();
  }

  GraphSync<G, Key> sync_;
  UpdateLimits limits_;
  bool information_ignored_ = false;
  Status status_;
};

}  // namespace hpgo
