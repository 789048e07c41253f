// The plugin of slam_toolbox under karto's sequence of calls.

#include <cmath>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "hpgo_solver.hpp"
#include "test/adapters/real_graphs.h"

namespace hpgo {
namespace {

using Scan = karto::LocalizedRangeScan;

karto::Pose2 ToKarto(const SE2& pose) {
  return karto::Pose2(pose.data()[0], pose.data()[1], pose.angle());
}
SE2 FromKarto(const karto::Pose2& pose) { return SE2(pose.GetX(), pose.GetY(), pose.GetHeading()); }

// As the mapper, which owns scans, vertices and edges.
class Mapper {
 public:
  explicit Mapper(karto::ScanSolver* solver) : solver_(solver) {}

  void AddScan(int id, const SE2& pose) {
    while (static_cast<int>(scans_.size()) <= id) {
      scans_.emplace_back(static_cast<int>(scans_.size()), karto::Pose2());
      vertices_.emplace_back(&scans_.back());
    }
    scans_[id].SetCorrectedPose(ToKarto(pose));
    solver_->AddNode(&vertices_[id]);
  }
  // The covariance of a link is along the axes of its first scan.
  void Link(int i, int j, const SE2& Z, const Eigen::Matrix3d& information) {
    Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
    R.topLeftCorner<2, 2>() = Z.matrix();
    const Eigen::Matrix3d covariance = (R * information * R.transpose()).inverse();
    karto::Matrix3 matrix;
    for (int k = 0; k < 9; ++k) matrix(k / 3, k % 3) = covariance(k / 3, k % 3);
    edges_.push_back(std::make_unique<karto::Edge<Scan>>(
        &vertices_[i], &vertices_[j], std::make_unique<karto::LinkInfo>(ToKarto(Z), matrix)));
    solver_->AddConstraint(edges_.back().get());
  }
  // The number of scans that the solver has returned.
  int CorrectPoses() {
    solver_->Compute();
    const auto corrections = solver_->GetCorrections();
    for (const auto& [id, pose] : corrections) scans_[id].SetCorrectedPose(pose);
    solver_->Clear();
    return static_cast<int>(corrections.size());
  }
  SE2 PoseOf(int id) const { return FromKarto(scans_[id].GetCorrectedPose()); }
  std::size_t size() const { return scans_.size(); }
  const std::deque<karto::Vertex<Scan>>& vertices() const { return vertices_; }
  const std::vector<std::unique_ptr<karto::Edge<Scan>>>& edges() const { return edges_; }

 private:
  karto::ScanSolver* solver_;
  std::deque<Scan> scans_;
  std::deque<karto::Vertex<Scan>> vertices_;
  std::vector<std::unique_ptr<karto::Edge<Scan>>> edges_;
};

class KartoGraphTest : public testing::TestWithParam<std::string> {};

TEST_P(KartoGraphTest, EndsAtTheOptimum) {
  const PoseGraph<SE2> graph = RealGraph<SE2>(GetParam());
  if (graph.nodes().empty()) GTEST_SKIP() << "no " << GetParam();
  solver_plugins::HpgoSolver solver;
  Mapper mapper(&solver);
  int closures = 0, computes = 0;
  const int computes_wanted = 8;
  const int closures_a_compute =
      1 + static_cast<int>(graph.edges().size() - graph.nodes().size()) / computes_wanted;
  for (const ReplayStep& step : ReplaySteps(graph)) {
    const Result<SE2> pose =
        StartPose<SE2>(graph, step, [&](int node) -> Result<SE2> { return mapper.PoseOf(node); });
    mapper.AddScan(step.node, pose->Normalized());
    for (const int e : step.edges) {
      const auto& edge = graph.edges()[e];
      mapper.Link(edge.i, edge.j, edge.measurement, edge.information);
      ASSERT_TRUE(solver.last_status().ok()) << solver.last_status().ToString();
      if (edge.j - edge.i != 1 && ++closures % closures_a_compute == 0) {
        mapper.CorrectPoses();
        ++computes;
      }
    }
  }
  PoseGraph<SE2> before;
  solver.WithOptimizer([&](Optimizer2d& optimizer) { before = optimizer.ToGraph(); });
  const double start = CpuMilliseconds();
  mapper.CorrectPoses();
  const double ms = CpuMilliseconds() - start;
  ASSERT_TRUE(solver.last_status().ok()) << solver.last_status().ToString();
  std::printf("%s: Compute %.1f ms of CPU time, ceres::Solve of the same %.1f ms\n",
              GetParam().c_str(), ms, CeresMilliseconds(before));
  solver.WithOptimizer([&](Optimizer2d& optimizer) {
    EXPECT_LT(Gap(optimizer), 1e-6);
    // The mapper has every correction.
    for (int k = 0; k < static_cast<int>(mapper.size()); ++k) {
      EXPECT_LT(mapper.PoseOf(k).LocalCoordinates(*optimizer.GetPose(k)).norm(), 1e-5) << k;
    }
  });
  EXPECT_EQ(mapper.CorrectPoses(), 0);  // nothing has changed
  EXPECT_EQ(solver.getGraph()->size(), graph.nodes().size());

  // A map is loaded: Reset, all nodes, all links, Compute.
  solver.Reset();
  EXPECT_TRUE(solver.getGraph()->empty());
  for (const auto& vertex : mapper.vertices()) {
    solver.AddNode(const_cast<karto::Vertex<Scan>*>(&vertex));
  }
  for (const auto& edge : mapper.edges()) solver.AddConstraint(edge.get());
  solver.Compute();
  solver.WithOptimizer([&](Optimizer2d& optimizer) { EXPECT_LT(Gap(optimizer), 1e-6); });
}
INSTANTIATE_TEST_SUITE_P(Graphs, KartoGraphTest,
                         testing::Values("g2o/M3500.g2o", "g2o/intel.g2o",
                                         "kitti/graphs/kitti_00.g2o", "city 10000"));

class KartoTest : public testing::Test {
 protected:
  // A square whose links close but for a turn.
  void AddSquare() {
    const SE2 step = SE2(1, 0, 1.5707963267948966);
    SE2 pose;
    for (int k = 0; k < 4; ++k) {
      mapper_.AddScan(k, pose);
      if (k > 0) mapper_.Link(k - 1, k, step, Eigen::Matrix3d::Identity());
      pose = pose * step * SE2(0, 0, 0.05);
    }
    mapper_.Link(3, 0, step, Eigen::Matrix3d::Identity());
  }
  solver_plugins::HpgoSolver solver_;
  Mapper mapper_{&solver_};
};

TEST_F(KartoTest, CorrectionsThatAreNotTakenAreNotLost) {
  AddSquare();
  solver_.Compute();
  const auto first = solver_.GetCorrections();
  EXPECT_EQ(first.size(), 3u);
  solver_.Compute();  // nothing has been taken
  const auto again = solver_.GetCorrections();
  ASSERT_EQ(again.size(), 3u);
  for (const auto& [id, pose] : again) {
    EXPECT_NEAR(pose.GetX(), solver_.getGraph()->at(id)(0), 1e-12);
  }
  solver_.Clear();
  EXPECT_TRUE(solver_.GetCorrections().empty());
  solver_.Compute();
  EXPECT_TRUE(solver_.GetCorrections().empty());
}

TEST_F(KartoTest, ModifyNodeAddsTheHeading) {
  AddSquare();
  double heading = 0;
  solver_.GetNodeOrientation(1, heading);
  EXPECT_NEAR(heading, 1.5707963267948966 + 0.05, 1e-12);
  solver_.ModifyNode(1, Eigen::Vector3d(5, 6, 0.25));
  solver_.GetNodeOrientation(1, heading);
  EXPECT_NEAR(heading, 1.5707963267948966 + 0.3, 1e-12);
  EXPECT_EQ(solver_.getGraph()->at(1)(0), 5);
  EXPECT_EQ(solver_.getGraph()->at(1)(1), 6);
  solver_.ModifyNode(9, Eigen::Vector3d::Zero());
  EXPECT_EQ(solver_.last_status().message(), "no node 9");
}

TEST_F(KartoTest, ACorrectionGoesWithWhatTheMapperHasPosedAnew) {
  AddSquare();
  solver_.Compute();
  ASSERT_EQ(solver_.GetCorrections().size(), 3u);
  // To where it is: nothing moves then.
  solver_.ModifyNode(1, solver_.getGraph()->at(1).cwiseProduct(Eigen::Vector3d(1, 1, 0)));
  solver_.Compute();
  for (const auto& [id, pose] : solver_.GetCorrections()) EXPECT_NE(id, 1);
  EXPECT_EQ(solver_.GetCorrections().size(), 2u);
}

TEST_F(KartoTest, RemovalAndErrors) {
  AddSquare();
  solver_.RemoveConstraint(0, 3);
  EXPECT_TRUE(solver_.last_status().ok());
  solver_.RemoveConstraint(0, 3);
  EXPECT_EQ(solver_.last_status().message(), "no link between the nodes 0 and 3");
  solver_.RemoveNode(3);
  EXPECT_TRUE(solver_.last_status().ok());
  EXPECT_EQ(solver_.getGraph()->count(3), 0u);
  solver_.AddNode(nullptr);
  solver_.AddConstraint(nullptr);
  mapper_.Link(0, 3, SE2(), Eigen::Matrix3d::Identity());
  EXPECT_EQ(solver_.last_status().message(), "edge 0 -> 3: no node 3");
  solver_.Compute();
  for (const auto& [id, pose] : solver_.GetCorrections()) EXPECT_NE(id, 3);
}

TEST_F(KartoTest, ParametersAreReadAndChecked) {
  auto node = std::make_shared<rclcpp::Node>();
  node->overrides["hpgo_loss"] = std::string("HuberLoss");
  node->overrides["hpgo_loss_scale"] = 1.0;
  node->overrides["hpgo_preset"] = std::string("fast");
  solver_.Configure(node);
  mapper_.AddScan(0, SE2());
  mapper_.AddScan(1, SE2());
  mapper_.Link(0, 1, SE2(10, 0, 0), Eigen::Matrix3d::Identity());
  solver_.WithOptimizer([](Optimizer2d& optimizer) {
    EXPECT_NEAR(optimizer.Cost(), 2 * 10 - 1, 1e-9);
    EXPECT_EQ(optimizer.options().window_nodes, OptimizerOptions::Fast().window_nodes);
  });
  solver_.Compute();
  EXPECT_EQ(solver_.GetCorrections().size(), 1u);
  auto coarse = std::make_shared<rclcpp::Node>();
  coarse->overrides["hpgo_min_correction_distance"] = 11.0;
  solver_.Configure(coarse);
  for (int k = 0; k < 2; ++k) mapper_.AddScan(k, SE2());
  mapper_.Link(0, 1, SE2(10, 0, 0), Eigen::Matrix3d::Identity());
  solver_.Compute();
  EXPECT_TRUE(solver_.GetCorrections().empty());
}

// RViz, mapping and service threads.
TEST_F(KartoTest, ThreadsMayCallIn) {
  AddSquare();
  std::thread reader([&] {
    for (int k = 0; k < 200; ++k) {
      EXPECT_GE(solver_.getGraph()->size(), 4u);
      double heading = 0;
      solver_.GetNodeOrientation(2, heading);
    }
  });
  std::thread service([&] {
    for (int k = 0; k < 50; ++k) solver_.ModifyNode(2, Eigen::Vector3d(1, 1, 0.01));
  });
  for (int k = 4; k < 60; ++k) {
    mapper_.AddScan(k, SE2(k, 0, 0));
    mapper_.Link(k - 1, k, SE2(1, 0, 0), Eigen::Matrix3d::Identity());
    if (k % 10 == 0) mapper_.CorrectPoses();
  }
  reader.join();
  service.join();
  EXPECT_EQ(solver_.getGraph()->size(), 60u);
}

}  // namespace
}  // namespace hpgo
