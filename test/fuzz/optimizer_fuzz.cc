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

#include "ceres/loss_function.h"
#include "ceres/sized_cost_function.h"
#include "hpgo/optimizer.h"
#include "test/fuzz/require.h"

namespace hpgo {
namespace {

// What is left of the input; zeros after its end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : next_(data), end_(data + size) {}
  bool empty() const { return next_ == end_; }
  std::uint8_t Byte() { return empty() ? 0 : *next_++; }
  int Below(int n) { return Byte() % n; }
  // Mostly tame.
  double Number() {
    constexpr double kOdd[] = {0,      std::numeric_limits<double>::quiet_NaN(),
                               1e300,  std::numeric_limits<double>::infinity(),
                               -1e300, -std::numeric_limits<double>::infinity(),
                               1e-310, 1e40,
                               1e-40,  -1e10,
                               1e-12,  M_PI,
                               -M_PI,  M_PI / 2,
                               1e6,    -1e-6};
    const std::uint8_t byte = Byte();
    if (byte < 240) return (byte - 120) / 30.;
    const double odd = kOdd[byte - 240];
    wild_ |= std::abs(odd) > 10 || (odd != 0 && std::abs(odd) < 1e-3);
    return odd;
  }
  // Whether a number was so large or small that rounding may be all there is.
  bool wild() const { return wild_; }

 private:
  const std::uint8_t* next_;
  const std::uint8_t* end_;
  bool wild_ = false;
};

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

  explicit Calls(Bytes* bytes) : bytes_(*bytes), optimizer_(Options()) {}

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
  OptimizerOptions Options() {
    OptimizerOptions options;
    options.max_group_size = 2 + bytes_.Below(3);
    options.max_top_nodes = 3 + bytes_.Below(8);
    options.condense_chains = bytes_.Below(5) > 0;
    options.window_nodes = 4 + bytes_.Below(40);
    options.window_edges = 8 + bytes_.Below(60);
    options.max_windows = 1 + bytes_.Below(6);
    const int kind = bytes_.Byte();
    options.engine = kind % 5 == 0 ? Engine::kCeres : Engine::kBlock;
    options.coarse_edges = kind % 7 == 0 ? CoarseEdges::kCondensed : CoarseEdges::kGalerkin;
    options.schedule = static_cast<Schedule>(kind % 11 == 0 ? 1 + kind % 2 : 0);
    options.convention = static_cast<ceres_costs::ErrorConvention>(kind % 3);
    return options;
  }

  // --- Values.
  NodeId AnyId() { return bytes_.Below(32); }
  EdgeId AnyEdge() {
    if (edges_.empty() || bytes_.Below(16) == 0) return EdgeId{bytes_.Below(64) - 1};
    return edges_[static_cast<std::size_t>(bytes_.Byte()) % edges_.size()];
  }
  G Pose() {
    double numbers[G::kParams];
    for (double& number : numbers) number = bytes_.Number();
    if (G::kDim == 3) numbers[G::kParams - 1] += 1;  // turns of less than half a turn mostly
    return G(numbers);
  }
  Matrix Information() {
    Matrix information = Matrix::Identity();
    const int kind = bytes_.Below(6);
    if (kind < 3) return information * std::abs(bytes_.Number());
    if (kind == 3) {
      for (int k = 0; k < G::kDof; ++k) information(k, k) = bytes_.Number();
    }
    if (kind >= 4) {  // of a rank that the bytes say
      information.setZero();
      for (int rank = bytes_.Below(4); rank >= 0; --rank) {
        typename G::Tangent v;
        for (int k = 0; k < G::kDof; ++k) v(k) = bytes_.Number();
        information += v * v.transpose();
      }
    }
    if (kind == 5) {
      information(0, 1) += bytes_.Number();
      information(1, 0) = information(0, 1);
    }
    return information;
  }
  typename Optimizer<G>::Loss Loss() {
    const double scale = 0.1 + bytes_.Below(40) / 10.;
    switch (bytes_.Below(8)) {
      case 0:
        return std::make_shared<ceres::HuberLoss>(scale);
      case 1:
        return std::make_shared<ceres::CauchyLoss>(scale);
      case 2:
        return std::make_shared<ceres::TukeyLoss>(scale);
      default:
        return nullptr;
    }
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
        return Note(optimizer_.AddPrior(AnyId(), Pose(), Information(),
                                        bytes_.Below(2) == 0 ? G() : Pose(), Loss()));
      case 8:
        return Note(optimizer_.AddCustomEdge(
            AnyId(), AnyId(), std::make_shared<Distance<G>>(std::abs(bytes_.Number())), Pose(),
            Information(), Loss()));
      case 9:
        return Note(optimizer_.UpdateEdge(AnyEdge(), Pose(), Information()));
      case 10:
        return Note(optimizer_.RemoveEdge(AnyEdge()));
      case 11:
        grouped_ = false;
        return Note(optimizer_.RemoveNode(AnyId()).status());
      case 12:
        return Note(optimizer_.SetFixed(AnyId(), bytes_.Below(2) == 0));
      case 13:
        return Note(optimizer_.SetPose(AnyId(), Pose()));
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
    const G step = Pose();
    const Result<G> at = optimizer_.GetPose(from);
    grouped_ = false;
    Note(optimizer_.AddNode(id, at.ok() ? *at * step : step));
    if (at.ok() && !refused_) {
      Note(optimizer_.AddEdge(from, id, step, Information(), Loss()));
      refused_ = false;  // the node is there
    }
  }
  void AddEdge() { Note(optimizer_.AddEdge(AnyId(), AnyId(), Pose(), Information(), Loss())); }
  void AddGraph() {
    PoseGraph<G> graph;
    const int nodes = 1 + bytes_.Below(4);
    for (int k = 0; k < nodes; ++k) {
      GraphNode<G> node;
      node.id = AnyId();
      node.has_pose = bytes_.Below(2) == 0;
      node.pose = Pose();
      node.fixed = bytes_.Below(8) == 0;
      (void)graph.AddNode(node);
    }
    for (int k = bytes_.Below(4); k > 0; --k) {
      GraphEdge<G> edge;
      edge.i = bytes_.Below(nodes);
      edge.j = bytes_.Below(nodes);
      edge.measurement = Pose();
      edge.information = Information();
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
