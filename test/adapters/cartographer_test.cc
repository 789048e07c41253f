// Cartographer's optimization problem, with stand-ins of its types.

#include "hpgo/adapters/cartographer_problem.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "test/adapters/cartographer_stand_ins.h"
#include "test/adapters/real_graphs.h"

namespace hpgo {
namespace {

template <typename G>
using Problem = CartographerProblem<G, StandIns<G>>;
template <typename G>
using Constraint = typename StandIns<G>::Constraint;
using Landmarks = std::map<std::string, int>;

// A front end that makes a submap every so many nodes and finds the graph's closures as
// constraints between submaps and nodes.
template <typename G>
class FrontEnd {
 public:
  FrontEnd(const PoseGraph<G>& graph, double huber_scale)
      : graph_(graph), steps_(ReplaySteps(graph)) {
    CartographerWeights weights;
    weights.huber_scale = huber_scale;
    const typename G::Matrix& information = graph.edges()[0].information;
    weights.local_slam_pose_translation_weight = std::sqrt(information(0, 0));
    weights.local_slam_pose_rotation_weight =
        std::sqrt(information(G::kDof - 1, G::kDof - 1)) / (G::kDim == 3 ? 2 : 1);
    translation_weight_ = weights.local_slam_pose_translation_weight;
    rotation_weight_ = weights.local_slam_pose_rotation_weight;
    problem_ = std::make_unique<Problem<G>>(weights);
  }
  int size() const { return static_cast<int>(graph_.nodes().size()); }

  void AddNode(int k) {
    constexpr int kNodesASubmap = 20;
    G step;
    for (const int e : steps_[k].edges) {
      const auto& edge = graph_.edges()[e];
      if (edge.i == k - 1 && edge.j == k) step = edge.measurement;
    }
    const G local = k == 0 ? graph_.nodes()[0].pose : (locals_[k - 1] * step).Normalized();
    const G global =
        k == 0 ? local : (problem_->node_data().at({0, k - 1}).global * step).Normalized();
    locals_.push_back(local);
    if (k % kNodesASubmap == 0) {
      submap_locals_.push_back(local);
      problem_->AddSubmap(0, global);
    }
    problem_->AddTrajectoryNode(0, {0.1 * k, local, global});
    const int submap = k / kNodesASubmap;
    Constrain(submap, k, submap_locals_[submap].Between(local), Constraint<G>::INTRA_SUBMAP);
    for (const int e : steps_[k].edges) {
      const auto& edge = graph_.edges()[e];
      const int seen = std::min(edge.i, edge.j), other = seen / kNodesASubmap;
      if (seen == k - 1 || other == submap || !inter_.insert({other, k}).second) continue;
      const G Z = edge.j == k ? edge.measurement : edge.measurement.Inverse();
      Constrain(other, k, submap_locals_[other].Between(locals_[seen]) * Z,
                Constraint<G>::INTER_SUBMAP);
    }
  }
  void Constrain(int submap, int node, const G& zbar, typename Constraint<G>::Tag tag) {
    constraints_.push_back(
        {{0, submap}, {0, node}, {zbar.Normalized(), translation_weight_, rotation_weight_}, tag});
  }
  void Solve() { problem_->Solve(constraints_, states_, Landmarks()); }

  const PoseGraph<G>& graph_;
  const std::vector<ReplayStep> steps_;
  std::vector<G> locals_, submap_locals_;
  std::set<std::pair<int, int>> inter_;
  std::vector<Constraint<G>> constraints_;
  std::map<int, typename StandIns<G>::TrajectoryState> states_;
  double translation_weight_ = 1, rotation_weight_ = 1;
  std::unique_ptr<Problem<G>> problem_;
};

template <typename G>
void ExpectOptimum(const std::string& name) {
  const PoseGraph<G> graph = RealGraph<G>(name);
  if (graph.nodes().empty()) GTEST_SKIP() << "no " << name;
  FrontEnd<G> front_end(graph, 1e9);  // a loss that never bends: full optimization has none
  const int n = front_end.size();
  double ms = 0;
  PoseGraph<G> last;
  for (int k = 0; k < n; ++k) {
    front_end.AddNode(k);
    if (k % (n / 4) != n / 4 - 1 && k + 1 != n) continue;
    const double start = CpuMilliseconds();
    front_end.Solve();
    ms = CpuMilliseconds() - start;
    if (k < 3 * n / 4) last = front_end.problem_->optimizer().ToGraph();
  }
  Problem<G>& problem = *front_end.problem_;
  ASSERT_TRUE(problem.status().ok()) << problem.status().ToString();
  EXPECT_LT(Gap(problem.optimizer()), 1e-6);
  // The same: the graph with what was there before the last Solve at the poses it had.
  PoseGraph<G> before = problem.optimizer().ToGraph();
  for (const GraphNode<G>& node : last.nodes()) before.node(*before.Find(node.id)).pose = node.pose;
  std::printf("%s: the last Solve %.1f ms of CPU time, ceres::Solve of the same %.1f ms\n",
              name.c_str(), ms, CeresMilliseconds(before));
  // The types hold the optimizer's poses; their sum of squares is its cost.
  double cost = 0;
  for (const auto& constraint : front_end.constraints_) {
    const G& submap = problem.submap_data().at(constraint.submap_id).global;
    const G& node = problem.node_data().at(constraint.node_id).global;
    const G error = constraint.pose.zbar_ij.Between(submap.Between(node));
    const typename G::Tangent e = G().LocalCoordinates(error);
    cost +=
        std::pow(constraint.pose.translation_weight, 2) * e.template head<G::kDim>().squaredNorm() +
        std::pow(constraint.pose.rotation_weight, 2) *
            e.template tail<G::kRotationDof>().squaredNorm();
  }
  EXPECT_LT(cost, problem.optimizer().Cost() * 1.01);
  EXPECT_GT(cost, 0);
}

TEST(CartographerTest, M3500) { ExpectOptimum<SE2>("g2o/M3500.g2o"); }
TEST(CartographerTest, Intel) { ExpectOptimum<SE2>("g2o/intel.g2o"); }
TEST(CartographerTest, Kitti00) { ExpectOptimum<SE2>("kitti/graphs/kitti_00.g2o"); }
TEST(CartographerTest, City2d) { ExpectOptimum<SE2>("city 10000"); }
TEST(CartographerTest, City3d) { ExpectOptimum<SE3>("city 3000"); }

template <typename G>
class CartographerTypesTest : public testing::Test {
 protected:
  CartographerTypesTest() : graph_(RealGraph<G>("city 600")), front_end_(graph_, 10) {}
  void Drive(int begin, int end) {
    for (int k = begin; k < end; ++k) front_end_.AddNode(k);
  }
  Problem<G>& problem() { return *front_end_.problem_; }
  double Moved(int k, const G& before) {
    return problem().node_data().at({0, k}).global.LocalCoordinates(before).norm();
  }
  PoseGraph<G> graph_;
  FrontEnd<G> front_end_;
};
using BothGroups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(CartographerTypesTest, BothGroups);

TYPED_TEST(CartographerTypesTest, HoldsTheFirstSubmapAndFrozenTrajectories) {
  using G = TypeParam;
  this->Drive(0, 300);
  const G first = this->problem().submap_data().at({0, 0}).global;
  this->front_end_.Solve();
  EXPECT_LT(this->problem().submap_data().at({0, 0}).global.LocalCoordinates(first).norm(), 1e-12);
  G off;
  off.translation()(0) = 1;
  const G node = this->problem().node_data().at({0, 150}).global;
  // A second trajectory sees the first, which does not move while it is frozen.
  this->problem().InsertTrajectoryNode({1, 0}, {0, G(), (node * off).Normalized()});
  this->front_end_.constraints_.push_back(
      {{0, 7}, {1, 0}, {G(), 1e3, 1e3}, Constraint<G>::INTER_SUBMAP});
  this->front_end_.states_[0] = StandIns<G>::TrajectoryState::FROZEN;
  this->front_end_.Solve();
  ASSERT_TRUE(this->problem().status().ok()) << this->problem().status().ToString();
  EXPECT_EQ(this->Moved(150, node), 0);
  const G there = this->problem().submap_data().at({0, 7}).global;
  EXPECT_LT(this->problem().node_data().at({1, 0}).global.LocalCoordinates(there).norm(), 1e-6);
}

TYPED_TEST(CartographerTypesTest, HuberIsOnConstraintsBetweenSubmaps) {
  using G = TypeParam;
  // A node between a submap of its own and one that is held, which want it 100 m apart.
  G far;
  far.translation()(0) = 100;
  CartographerWeights weights;
  Problem<G> problem(weights);
  problem.AddSubmap(0, G());
  problem.AddSubmap(1, G());
  problem.AddTrajectoryNode(0, {0, G(), G()});
  std::map<int, typename StandIns<G>::TrajectoryState> states;
  states[1] = StandIns<G>::TrajectoryState::FROZEN;
  std::vector<Constraint<G>> constraints = {
      {{0, 0}, {0, 0}, {G(), 1, 1}, Constraint<G>::INTRA_SUBMAP},
      {{1, 0}, {0, 0}, {far, 1, 1}, Constraint<G>::INTER_SUBMAP}};
  problem.Solve(constraints, states, Landmarks());
  ASSERT_TRUE(problem.status().ok()) << problem.status().ToString();
  EXPECT_NEAR(problem.node_data().at({0, 0}).global.translation()(0), weights.huber_scale, 1e-4);
  constraints[1].tag = Constraint<G>::INTRA_SUBMAP;
  problem.Solve(constraints, states, Landmarks());
  EXPECT_NEAR(problem.node_data().at({0, 0}).global.translation()(0), 50, 1e-4);
}

TYPED_TEST(CartographerTypesTest, TrimmingTakesConstraintsAway) {
  this->Drive(0, 200);
  this->front_end_.Solve();
  this->problem().TrimSubmap({0, 3});
  for (int k = 60; k < 80; ++k) this->problem().TrimTrajectoryNode({0, k});
  auto& constraints = this->front_end_.constraints_;
  constraints.erase(std::remove_if(constraints.begin(), constraints.end(),
                                   [](const auto& c) {
                                     const int k = c.node_id.node_index;
                                     return c.submap_id.submap_index == 3 || (k >= 60 && k < 80);
                                   }),
                    constraints.end());
  this->front_end_.Solve();
  ASSERT_TRUE(this->problem().status().ok()) << this->problem().status().ToString();
  EXPECT_EQ(this->problem().optimizer().num_nodes(), 180u + 9u);
  this->problem().InsertSubmap({0, 3}, TypeParam());  // a map that is loaded
  this->front_end_.Solve();
  EXPECT_EQ(this->problem().optimizer().num_nodes(), 180u + 10u);
}

TYPED_TEST(CartographerTypesTest, OdometryTiesNodes) {
  using G = TypeParam;
  this->Drive(0, 3);
  G odometry;
  for (int k = 0; k < 8; ++k) {
    this->problem().AddOdometryData(0, {0.05 * k - 0.02, odometry});
    odometry.translation()(0) += 1;
  }
  this->front_end_.Solve();
  // Two of local SLAM and two of odometry beside the constraints.
  const Optimizer<G>& optimizer = this->problem().optimizer();
  EXPECT_EQ(optimizer.num_edges(), 3u + 2u + 2u);
  // Nodes are 0.1 s apart, and the odometry has a metre in 0.05 s.
  G two_metres;
  two_metres.translation()(0) = 2;
  int found = 0;
  const PoseGraph<G> graph = optimizer.ToGraph();
  for (const GraphEdge<G>& edge : graph.edges()) {
    found += edge.measurement.LocalCoordinates(two_metres).norm() < 1e-9;
  }
  EXPECT_EQ(found, 2);
  // None beyond the last measurement.
  this->Drive(3, 6);
  this->front_end_.Solve();
  EXPECT_EQ(optimizer.num_edges(), 6u + 5u + 3u);
}

TYPED_TEST(CartographerTypesTest, AConstraintTwiceIsRefused) {
  this->Drive(0, 10);
  this->front_end_.constraints_.push_back(this->front_end_.constraints_.back());
  this->front_end_.Solve();
  EXPECT_EQ(this->problem().status().code(), StatusCode::kAlreadyExists);
  this->front_end_.constraints_.pop_back();
  this->front_end_.Solve();
  EXPECT_TRUE(this->problem().status().ok()) << this->problem().status().ToString();
}

TYPED_TEST(CartographerTypesTest, WhatIsNotTakenIsRefusedByName) {
  using G = TypeParam;
  this->Drive(0, 30);
  const G node = this->problem().node_data().at({0, 20}).global;
  this->problem().Solve(this->front_end_.constraints_, this->front_end_.states_,
                        Landmarks{{"pillar", 1}});
  EXPECT_EQ(this->problem().status().message(), "costs of landmarks are not taken: pillar");
  EXPECT_EQ(this->Moved(20, node), 0);
  this->front_end_.Solve();
  EXPECT_TRUE(this->problem().status().ok());
  this->problem().AddImuData(0, {});
  this->front_end_.Solve();
  EXPECT_EQ(this->problem().status().message(),
            G::kDim == 2 ? "" : "rotation and acceleration costs of the IMU are not taken");
  this->problem().AddFixedFramePoseData(0, 0);
  this->front_end_.Solve();
  EXPECT_EQ(this->problem().status().message(), "costs of fixed frames are not taken");
}

}  // namespace
}  // namespace hpgo
