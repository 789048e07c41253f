// A random sequence of every call on one optimizer, with what holds after each and at rest.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iostream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "ceres/loss_function.h"
#include "ceres_costs/losses.h"
#include "gtest/gtest.h"
#include "hpgo/optimizer.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {

template <typename G>
class Sequence {
 public:
  explicit Sequence(std::uint64_t seed) : rng_(seed), optimizer_(RandomOptions()) {
    own_frames_ = Chance(0.3);
    robust_ = Chance(0.3);
    if (robust_) {
      loss_name_ = Chance(0.5) ? "huber" : "cauchy";
      std::unique_ptr<ceres::LossFunction> loss;
      std::string error;
      EXPECT_TRUE(ceres_costs::MakeLoss(loss_name_, kLossScale, &loss, &error)) << error;
      loss_ = std::move(loss);
    }
  }

  // Stops at the first failure.
  void Run() {
    const int steps = 20 + Below(100);
    for (int step = 0; step < steps && !testing::Test::HasFailure(); ++step) {
      history_ += std::to_string(step) + ": " + Act() + "\n";
      Check();
    }
    if (!testing::Test::HasFailure()) {
      history_ += RefineToRest() + "\n";
      Check();
    }
    if (testing::Test::HasFailure()) std::cout << history_;
  }

  // How often the optimizer came to rest, and how often more than 0.01 % above
  // the optimum.
  int rests() const { return rests_; }
  int off() const { return off_; }
  // How often it was not compared, since an edge stood at the half turn.
  int half_turns() const { return half_turns_; }

 private:
  static constexpr double kSigma[2] = {0.05, 0.02};  // m, rad
  static constexpr double kLossScale = 3;
  static constexpr double kNearHalfTurn = 0.1;  // rad
  static constexpr std::size_t kMaxNodes = 60;

  struct Node {
    G truth;
    bool fixed = false;
    G fixed_at;
  };
  struct Edge {
    EdgeId id;
    NodeId i, j;  // i == j: a prior
  };
  using Tangent = typename G::Tangent;
  using Matrix = typename G::Matrix;

  // --- Randomness.
  double Uniform() { return std::uniform_real_distribution<double>(0, 1)(rng_); }
  bool Chance(double p) { return Uniform() < p; }
  int Below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(rng_); }
  OptimizerOptions RandomOptions() {
    OptimizerOptions options;
    options.max_group_size = 2 + Below(3);
    options.max_top_nodes = 3 + Below(8);
    options.condense_chains = Chance(0.8);
    options.window_nodes = Chance(0.5) ? 100 : 8 + Below(15);
    options.window_edges = Chance(0.7) ? 1000 : 20 + Below(50);
    options.max_windows = 1 + Below(6);
    options.max_examined = Chance(0.7) ? 300 : 1 + Below(4);
    options.max_merges = Chance(0.8) ? 2000 : 1 + Below(10);
    options.engine = Chance(0.2) ? Engine::kCeres : Engine::kBlock;
    return options;
  }
  Matrix Information() {
    Tangent weights;
    for (int k = 0; k < G::kDof; ++k) weights(k) = 1 / kSigma[k >= G::kDim];
    return weights.asDiagonal() * RandomInformation<G>(&rng_) * weights.asDiagonal();
  }
  G Noise() { return RandomPose<G>(&rng_, 1.5 * kSigma[0], 1.5 * kSigma[1]); }
  NodeId AnyNode() { return std::next(nodes_.begin(), Below(nodes_.size()))->first; }
  // Of T_i_j; now and then wrong where a loss will bear it.
  G Measure(NodeId i, NodeId j) {
    const G truth = nodes_[i].truth.Between(nodes_[j].truth);
    if (robust_ && Chance(0.1)) return truth * RandomPose<G>(&rng_, 3, 0.5);
    return truth * Noise();
  }

  // --- The calls. Each returns what it did, for the trace.
  std::string Act() {
    if (nodes_.empty()) return AddComponent();
    const double dice = Uniform();
    if (dice < 0.30) return AddAttachedNode();
    if (dice < 0.33) return AddComponent();
    if (dice < 0.45) return AddEdge();
    if (dice < 0.50) return own_frames_ ? AddEdge() : AddPrior();
    if (dice < 0.54) return RemoveEdge();
    if (dice < 0.58) return RemoveNode();
    if (dice < 0.62) return UpdateEdge();
    if (dice < 0.66) return own_frames_ ? UpdateEdge() : ToggleFixed();
    if (dice < 0.69) return SetPose();
    if (dice < 0.72) return RefineToRest();
    if (dice < 0.74) return Solve(Chance(0.5) ? Mode::kFull : Mode::kTop);
    return Solve(Mode::kPartial);
  }

  std::string AddNode(const G& truth, const G& pose) {
    const NodeId id = next_id_++;
    EXPECT_TRUE(optimizer_.AddNode(id, pose).ok());
    EXPECT_EQ(optimizer_.AddNode(id, pose).code(), StatusCode::kAlreadyExists);
    nodes_[id] = {truth, false, G()};
    grouped_ = false;
    return "add node " + std::to_string(id);
  }
  std::string AddComponent() {
    if (nodes_.size() >= kMaxNodes) return RemoveNode();
    const G truth = RandomPose<G>(&rng_, 5, 2);
    return AddNode(truth, own_frames_ ? RandomPose<G>(&rng_, 20, 3) : truth * Noise());
  }
  std::string AddAttachedNode() {
    if (nodes_.size() >= kMaxNodes) return RemoveNode();
    const NodeId from = Chance(0.7) ? nodes_.rbegin()->first : AnyNode(), to = next_id_;
    const G step = RandomPose<G>(&rng_, 1, 0.7);
    const std::string name =
        AddNode(nodes_[from].truth * step, *optimizer_.GetPose(from) * step * Noise());
    return name + ", " + AddEdge(from, to);
  }
  std::string AddEdge() {
    const NodeId i = AnyNode(), j = AnyNode();
    return i == j ? Solve(Mode::kPartial) : AddEdge(i, j);
  }
  std::string AddEdge(NodeId i, NodeId j) {
    const Result<EdgeId> id = optimizer_.AddEdge(i, j, Measure(i, j), Information(), loss_);
    EXPECT_TRUE(id.ok()) << id.status().ToString();
    edges_.push_back({*id, i, j});
    return "add edge " + std::to_string(i) + " -> " + std::to_string(j);
  }
  std::string AddPrior() {
    const NodeId node = AnyNode();
    const G offset = Chance(0.5) ? G() : RandomPose<G>(&rng_, 1, 1);
    Tangent measured = Tangent::Ones();
    const int kind = Below(4);  // full, position, planar position, attitude
    if (kind == 1) measured.template tail<G::kRotationDof>().setZero();
    if (kind == 2) measured.template tail<G::kDof - 2>().setZero();
    if (kind == 3) measured.template head<G::kDim>().setZero();
    const Matrix information = measured.asDiagonal() * Information() * measured.asDiagonal();
    const Result<EdgeId> id =
        optimizer_.AddPrior(node, nodes_[node].truth * offset * Noise(), information, offset);
    EXPECT_TRUE(id.ok()) << id.status().ToString();
    edges_.push_back({*id, node, node});
    return "add prior of kind " + std::to_string(kind) + " on " + std::to_string(node);
  }
  std::string RemoveEdge() {
    if (edges_.empty()) return AddComponent();
    const int at = Below(edges_.size());
    const Edge edge = edges_[at];
    edges_.erase(edges_.begin() + at);
    EXPECT_TRUE(optimizer_.RemoveEdge(edge.id).ok());
    EXPECT_EQ(optimizer_.RemoveEdge(edge.id).code(), StatusCode::kNotFound);
    return "remove edge " + std::to_string(edge.i) + " -> " + std::to_string(edge.j);
  }
  std::string RemoveNode() {
    const NodeId node = AnyNode();
    EXPECT_TRUE(optimizer_.RemoveNode(node).ok());
    nodes_.erase(node);
    std::vector<Edge> left;
    for (const Edge& edge : edges_) {
      if (edge.i != node && edge.j != node) left.push_back(edge);
    }
    edges_.swap(left);
    return "remove node " + std::to_string(node);
  }
  std::string UpdateEdge() {
    if (edges_.empty()) return AddComponent();
    const Edge& edge = edges_[Below(edges_.size())];
    const bool prior = edge.i == edge.j;
    const G measurement = prior ? nodes_[edge.i].truth * Noise() : Measure(edge.i, edge.j);
    EXPECT_TRUE(optimizer_.UpdateEdge(edge.id, measurement, Information()).ok());
    return "update edge " + std::to_string(edge.i) + " -> " + std::to_string(edge.j);
  }
  std::string ToggleFixed() {
    const NodeId id = AnyNode();
    Node& node = nodes_[id];
    node.fixed = !node.fixed;
    node.fixed_at = *optimizer_.GetPose(id);
    EXPECT_TRUE(optimizer_.SetFixed(id, node.fixed).ok());
    return (node.fixed ? "fix " : "release ") + std::to_string(id);
  }
  std::string SetPose() {
    const NodeId id = AnyNode();
    const G pose = *optimizer_.GetPose(id) * RandomPose<G>(&rng_, 1, 0.5);
    EXPECT_TRUE(optimizer_.SetPose(id, pose).ok());
    nodes_[id].fixed_at = pose;
    return "set pose of " + std::to_string(id);
  }
  std::string Solve(Mode mode) {
    const UpdateReport report = optimizer_.Optimize(mode);
    EXPECT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_GE(report.cost_decrease, 0);
    grouped_ = true;
    return "update in mode " + std::to_string(static_cast<int>(mode));
  }
  std::string RefineToRest() {
    const UpdateReport report = optimizer_.Refine();
    EXPECT_TRUE(report.status.ok()) << report.status.ToString();
    EXPECT_TRUE(report.at_rest);
    grouped_ = true;
    const Optimum<G> optimum = OptimumFrom(optimizer_, robust_ ? loss_name_ : "none", kLossScale);
    // Where the loss is not convex a full solve may leave for another minimum.
    if (loss_name_ != "cauchy" && !StandsAtHalfTurn(optimum.graph)) {
      ++rests_;
      const double small = 1e-5 * edges_.size();  // of the noise's chi2
      off_ += optimizer_.Cost() > optimum.cost * (1 + 1e-4) + small;
      // Outliers make valleys along which a full solve itself creeps for hundreds of iterations.
      if (!robust_) {
        EXPECT_LE(optimizer_.Cost(), optimum.cost * (1 + 3e-2) + small);
      }
    }
    return "refine";
  }
  // The error of an edge at the half turn jumps, and with it the cost: the full solve may be on the
  // other side. Counted, not compared.
  bool StandsAtHalfTurn(const PoseGraph<G>& optimum) {
    const PoseGraph<G> graph = optimizer_.ToGraph();
    for (const PoseGraph<G>* poses : {&graph, &optimum}) {
      for (const GraphEdge<G>& edge : poses->edges()) {
        const G T = poses->nodes()[edge.i].pose.Between(poses->nodes()[edge.j].pose);
        const typename G::Tangent d = edge.measurement.LocalCoordinates(T);
        if (d.template tail<G::kRotationDof>().norm() < M_PI - kNearHalfTurn) continue;
        ++half_turns_;
        return true;
      }
    }
    return false;
  }

  // --- What holds after every call.
  void Check() {
    if (grouped_) {
      EXPECT_EQ(optimizer_.FindInconsistency(), "");
    }
    EXPECT_EQ(optimizer_.num_nodes(), nodes_.size());
    EXPECT_EQ(optimizer_.num_edges(), edges_.size());
    for (const auto& [id, node] : nodes_) {
      const Result<G> pose = optimizer_.GetPose(id);
      ASSERT_TRUE(pose.ok()) << pose.status().ToString();
      for (int k = 0; k < G::kParams; ++k) ASSERT_TRUE(std::isfinite(pose->data()[k])) << id;
      if (node.fixed) {
        EXPECT_LT(node.fixed_at.LocalCoordinates(*pose).norm(), 1e-12) << id;
      }
    }
    for (const Edge& edge : edges_) {
      const Result<EdgeError> error = optimizer_.GetEdgeError(edge.id);
      ASSERT_TRUE(error.ok()) << error.status().ToString();
      EXPECT_EQ(error->i, edge.i);
      EXPECT_EQ(error->j, edge.j);
      EXPECT_TRUE(error->chi2 >= 0);
    }
  }

  std::mt19937_64 rng_;
  Optimizer<G> optimizer_;
  bool own_frames_ = false;  // components start anywhere, and nothing but edges relates them
  bool robust_ = false;
  std::string loss_name_;
  std::shared_ptr<const ceres::LossFunction> loss_;
  std::map<NodeId, Node> nodes_;
  std::vector<Edge> edges_;
  NodeId next_id_ = 0;
  std::string history_;
  int rests_ = 0, off_ = 0, half_turns_ = 0;
  bool grouped_ = true;  // no node was added since the last update
};

}  // namespace hpgo
