// A string of bytes as a sequence of the Optimizer's calls, with odd values among them. After each:
// a call that was refused has changed nothing, the structure is consistent, the poses are finite,
// and no solve has raised the cost in silence. That Refine ends is seen by the time an input takes.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ceres/sized_cost_function.h"
#include "hpgo/optimizer.h"
#include "test/fuzz/require.h"
#include "test/fuzz/values.h"

namespace hpgo {
namespace {

// |p_i - p_j| - distance; fails where the points are close, or in the frame of the world.
template <typename G>
class Distance : public ceres::SizedCostFunction<1, G::kParams, G::kParams> {
 public:
  explicit Distance(double distance) : distance_(distance) {}
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    using Point = Eigen::Matrix<double, G::kDim, 1>;
    const Eigen::Map<const Point> i(x[0]), j(x[1]);
    const Point to = j - i;
    const double d = to.norm();
    *r = d - distance_;
    for (int k = 0; k < 2 && J != nullptr; ++k) {
      if (J[k] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, 1, G::kParams>> row(J[k]);
      row.setZero();
      row.template head<G::kDim>() = (k == 0 ? -1 : 1) * to.transpose() / d;
    }
    return d > 0.1;
  }

 private:
  const double distance_;
};

template <typename G>
class Calls {
 public:
  using Matrix = typename G::Matrix;

  explicit Calls(Bytes* bytes) : bytes_(*bytes), values_(bytes), optimizer_(values_.Options()) {}

  void Run() {
    constexpr int kMostCalls = 120;
    for (int k = 0; k < kMostCalls && !bytes_.empty(); ++k) {
      const std::size_t nodes = optimizer_.num_nodes(), edges = optimizer_.num_edges();
      refused_ = false;
      Call();
      if (refused_) {
        Require(optimizer_.num_nodes() == nodes && optimizer_.num_edges() == edges,
                "a refused call has changed the graph");
      }
      Check();
    }
    Solve(3);
    Check();
  }

 private:
  // --- Arguments.
  NodeId AnyId() { return bytes_.Below(32); }
  EdgeId AnyEdge() {
    if (edges_.empty() || bytes_.Below(16) == 0) return EdgeId{bytes_.Below(64) - 1};
    return edges_[static_cast<std::size_t>(bytes_.Byte()) % edges_.size()];
  }
  UpdateLimits Limits() {
    constexpr double kSeconds[] = {0, 0, 0, 1e-9, 1e-4, -1, 1e-3, 0};
    UpdateLimits limits;
    limits.max_seconds = kSeconds[bytes_.Below(8)];
    cancel_ = bytes_.Below(16) == 0;
    limits.cancel = &cancel_;
    return limits;
  }

  // --- Calls.
  void Note(const Status& status) {
    refused_ = !status.ok();
    Require(status.ok() || !status.message().empty(), "an error without a message");
  }
  void Note(const Result<EdgeId>& edge) {
    Note(edge.status());
    if (edge.ok()) edges_.push_back(*edge);
  }

  void Call() {
    switch (bytes_.Below(24)) {
      case 0:
      case 1:
      case 2:
        return AddNode();
      case 3:
      case 4:
      case 5:
      case 6:
        return AddEdge();
      case 7:
        return Note(optimizer_.AddPrior(AnyId(), values_.Pose(), values_.Information(),
                                        bytes_.Below(2) == 0 ? G() : values_.Pose(),
                                        values_.Loss()));
      case 8:
        return Note(optimizer_.AddCustomEdge(
            AnyId(), AnyId(), std::make_shared<Distance<G>>(std::abs(bytes_.Number())),
            values_.Pose(), values_.Information(), values_.Loss()));
      case 9:
        return Note(optimizer_.UpdateEdge(AnyEdge(), values_.Pose(), values_.Information()));
      case 10:
        return Note(optimizer_.RemoveEdge(AnyEdge()));
      case 11:
        grouped_ = false;
        return Note(optimizer_.RemoveNode(AnyId()).status());
      case 12:
        return Note(optimizer_.SetFixed(AnyId(), bytes_.Below(2) == 0));
      case 13:
        return Note(optimizer_.SetPose(AnyId(), values_.Pose()));
      case 14:
        return Moved();
      case 15: {
        const Result<Matrix> covariance = optimizer_.MarginalCovariance(AnyId());
        Note(covariance.status());
        Require(!covariance.ok() || covariance->allFinite(), "the covariance is not finite");
        const auto bounded = optimizer_.BoundedMarginalCovariance(AnyId(), bytes_.Below(20));
        Note(bounded.status());
        Require(!bounded.ok() || bounded->covariance.allFinite(),
                "the bounded covariance is not finite");
        return;
      }
      case 16:
        return AddGraph();
      case 17:
        (void)optimizer_.GetGroup(AnyId(), bytes_.Below(8) - 1);
        (void)optimizer_.EdgeErrors();
        return Note(optimizer_.GetEdgeError(AnyEdge()).status());
      default:
        return Solve(bytes_.Below(8));
    }
  }
  // In one of two: where the edges of a chain would have it.
  void AddNode() {
    const NodeId id = AnyId(), from = AnyId();
    const G step = values_.Pose();
    const Result<G> at = optimizer_.GetPose(from);
    grouped_ = false;
    Note(optimizer_.AddNode(id, at.ok() ? *at * step : step));
    if (at.ok() && !refused_) {
      Note(optimizer_.AddEdge(from, id, step, values_.Information(), values_.Loss()));
      refused_ = false;  // the node is there
    }
  }
  void AddEdge() {
    Note(optimizer_.AddEdge(AnyId(), AnyId(), values_.Pose(), values_.Information(),
                            values_.Loss()));
  }
  void AddGraph() {
    PoseGraph<G> graph;
    const int nodes = 1 + bytes_.Below(4);
    for (int k = 0; k < nodes; ++k) {
      GraphNode<G> node;
      node.id = AnyId();
      node.has_pose = bytes_.Below(2) == 0;
      node.pose = values_.Pose();
      node.fixed = bytes_.Below(8) == 0;
      (void)graph.AddNode(node);
    }
    for (int k = bytes_.Below(4); k > 0; --k) {
      GraphEdge<G> edge;
      edge.i = bytes_.Below(nodes);
      edge.j = bytes_.Below(nodes);
      edge.measurement = values_.Pose();
      edge.information = values_.Information();
      (void)graph.AddEdge(edge);
    }
    grouped_ = false;
    Note(optimizer_.AddGraph(graph));
  }
  void Moved() {
    constexpr double kLimits[] = {0, -1, 0.1, 1e300, std::numeric_limits<double>::quiet_NaN()};
    const double distance = kLimits[bytes_.Below(5)], angle = kLimits[bytes_.Below(5)];
    std::vector<NodeId> seen;
    optimizer_.ForEachMoved(distance, angle, [&](NodeId id, const G&) { seen.push_back(id); });
    std::sort(seen.begin(), seen.end());
    Require(std::adjacent_find(seen.begin(), seen.end()) == seen.end(), "a node visited twice");
    Require(distance >= 0 || std::isnan(distance) || seen.size() == optimizer_.num_nodes(),
            "a node not visited");
  }
  // Only full solves are held to it: partial updates may raise the cost a little where the models
  // of the levels disagree.
  void Solve(int kind) {
    const UpdateLimits limits = Limits();
    if (kind == 4) optimizer_.Optimize(Mode::kFull, limits);
    const double before = optimizer_.Cost();
    UpdateReport report;
    if (kind < 4) {
      report = optimizer_.Refine(limits);
    } else if (kind < 6) {
      report = optimizer_.Optimize(kind == 4 ? Mode::kFull : Mode::kTop, limits);
    } else {
      report = optimizer_.Update(limits);
    }
    grouped_ = true;
    const double after = optimizer_.Cost();
    if (kind != 4 || bytes_.wild() || !report.status.ok() || !std::isfinite(before)) return;
    Require(after <= before * (1 + 1e-6) + 1e-6,
            "the cost rose from " + std::to_string(before) + " to " + std::to_string(after));
  }

  void Check() {
    if (grouped_) {
      const std::string fault = optimizer_.FindInconsistency();
      Require(fault.empty(), fault);
    }
    optimizer_.ForEachPose([&](NodeId id, const G& pose) {
      for (int k = 0; k < G::kParams; ++k) {
        Require(std::isfinite(pose.data()[k]), "the pose of node " + std::to_string(id));
      }
    });
  }

  Bytes& bytes_;
  Values<G> values_;
  Optimizer<G> optimizer_;
  std::vector<EdgeId> edges_;
  std::atomic<bool> cancel_{false};
  bool refused_ = false;
  bool grouped_ = true;
};

}  // namespace
}  // namespace hpgo

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  hpgo::Bytes bytes(data, size);
  if (bytes.Below(2) == 0) {
    hpgo::Calls<hpgo::SE2>(&bytes).Run();
  } else {
    hpgo::Calls<hpgo::SE3>(&bytes).Run();
  }
  return 0;
}
