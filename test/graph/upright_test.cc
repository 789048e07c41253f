// Graphs of known roll and pitch: their costs are those of the 3D graph where the yaw and the
// translation move.
#include "hpgo/graph/upright.h"

#include <cmath>
#include <random>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;
using ::testing::HasSubstr;

class UprightTest : public testing::TestWithParam<ErrorConvention> {
 protected:
  SE3 RandomPose(double length, double angle) {
    SE3::Tangent d;
    for (int k = 0; k < 6; ++k) d(k) = (k < 3 ? length : angle) * Uniform();
    return SE3().Retract(d);
  }
  double Uniform() { return std::uniform_real_distribution<double>(-1, 1)(random_); }

  SE3::Matrix RandomInformation(int rows) {
    SE3::Matrix a = SE3::Matrix::Zero();
    for (int r = 0; r < rows; ++r) {
      for (int c = 0; c < rows; ++c) a(r, c) = Uniform() + (r == c ? 2 : 0);
    }
    return a * a.transpose();
  }

  // Nodes anyhow turned, an edge between each and the next and a prior on each, exact.
  PoseGraph<SE3> Exact(int prior_rows) {
    PoseGraph<SE3> graph;
    for (int n = 0; n < 8; ++n) {
      GraphNode<SE3> node;
      node.id = 10 * n;
      node.pose = RandomPose(5, 2);
      EXPECT_TRUE(graph.AddNode(node).ok());
    }
    for (int n = 0; n + 1 < 8; ++n) {
      GraphEdge<SE3> edge;
      edge.i = n;
      edge.j = n + 1;
      edge.measurement = graph.nodes()[n].pose.Between(graph.nodes()[n + 1].pose);
      edge.information = RandomInformation(6);
      EXPECT_TRUE(graph.AddEdge(edge).ok());
    }
    for (int n = 0; n < 8; ++n) {
      GraphPrior<SE3> prior;
      prior.node = n;
      prior.offset = RandomPose(1, 1);
      prior.measurement = graph.nodes()[n].pose * prior.offset;
      // A position comes with any rotation; the logarithm has none without the other.
      if (prior_rows == 3 && GetParam() == ErrorConvention::kG2o) {
        prior.measurement.rotation() = RandomPose(0, 2).rotation();
      }
      prior.information = RandomInformation(prior_rows);
      EXPECT_TRUE(graph.AddPrior(prior).ok());
    }
    return graph;
  }

  template <typename G>
  double EdgeCost(const GraphEdge<G>& edge, const G& X_i, const G& X_j) const {
    const typename G::Tangent e =
        ceres_costs::RelativePoseError<G>(GetParam(), edge.measurement, X_i.Between(X_j), nullptr);
    return e.dot(edge.information * e);
  }
  template <typename G>
  double PriorCost(const GraphPrior<G>& prior, const G& X) const {
    const typename G::Tangent e =
        ceres_costs::RelativePoseError<G>(GetParam(), prior.measurement, X * prior.offset, nullptr);
    return e.dot(prior.information * e);
  }

  // Each node moved by `size`, upright, and the same poses in 3D.
  void Move(const UprightGraph& upright, double size, std::vector<YawPose>* Y,
            std::vector<SE3>* X) {
    for (std::size_t n = 0; n < upright.graph.nodes().size(); ++n) {
      YawPose::Tangent d;
      for (int k = 0; k < 4; ++k) d(k) = size * Uniform();
      Y->push_back(upright.graph.nodes()[n].pose.Retract(d));
      X->push_back(upright.Tilted(static_cast<int>(n), Y->back()));
    }
  }

  std::mt19937 random_{3};
};

INSTANTIATE_TEST_SUITE_P(Errors, UprightTest,
                         testing::Values(ErrorConvention::kG2o, ErrorConvention::kTwist),
                         [](const auto& instance) {
                           return instance.param == ErrorConvention::kG2o ? "G2o" : "Twist";
                         });

TEST_P(UprightTest, PosesComeBack) {
  const PoseGraph<SE3> graph = Exact(6);
  const Result<UprightGraph> upright = MakeUpright(graph, GetParam());
  ASSERT_TRUE(upright.ok());
  ASSERT_EQ(upright->graph.nodes().size(), graph.nodes().size());
  for (std::size_t n = 0; n < graph.nodes().size(); ++n) {
    const GraphNode<YawPose>& node = upright->graph.nodes()[n];
    EXPECT_EQ(node.id, graph.nodes()[n].id);
    EXPECT_LE(upright->Tilted(static_cast<int>(n), node.pose)
                  .LocalCoordinates(graph.nodes()[n].pose)
                  .norm(),
              1e-12);
    // A turn about z is no tilt.
    EXPECT_NEAR(upright->tilts[n].z(), 0, 1e-12);
  }
}

TEST_P(UprightTest, CostsAreThoseOfTheGraph) {
  for (const int prior_rows : {6, 3}) {
    const PoseGraph<SE3> graph = Exact(prior_rows);
    const Result<UprightGraph> upright = MakeUpright(graph, GetParam());
    ASSERT_TRUE(upright.ok());
    constexpr double kSize = 1e-5;
    std::vector<YawPose> Y;
    std::vector<SE3> X;
    Move(*upright, kSize, &Y, &X);
    for (std::size_t k = 0; k < graph.edges().size(); ++k) {
      const GraphEdge<SE3>& edge = graph.edges()[k];
      const double cost = EdgeCost(edge, X[edge.i], X[edge.j]);
      EXPECT_NEAR(EdgeCost(upright->graph.edges()[k], Y[edge.i], Y[edge.j]), cost, 1e-3 * cost);
      EXPECT_GT(cost, 0);
    }
    for (std::size_t k = 0; k < graph.priors().size(); ++k) {
      const GraphPrior<SE3>& prior = graph.priors()[k];
      const double cost = PriorCost(prior, X[prior.node]);
      EXPECT_NEAR(PriorCost(upright->graph.priors()[k], Y[prior.node]), cost, 1e-3 * cost);
      EXPECT_GT(cost, 0);
    }
  }
}

// Where the measured roll and pitch are not the known ones, the rest counts.
TEST_P(UprightTest, MeasuredTiltIsLeftOut) {
  PoseGraph<SE3> graph;
  GraphNode<SE3> node;
  ASSERT_TRUE(graph.AddNode(node).ok());
  node.id = 1;
  node.pose.translation() = Eigen::Vector3d(1, 0, 0);
  ASSERT_TRUE(graph.AddNode(node).ok());
  GraphEdge<SE3> edge;
  edge.j = 1;
  edge.measurement.translation() = Eigen::Vector3d(1, 2, 3);
  edge.measurement.rotation() =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  const Result<UprightGraph> upright = MakeUpright(graph, GetParam());
  ASSERT_TRUE(upright.ok());
  const YawPose expected(1, 2, 3, 0.3);
  EXPECT_LE(upright->graph.edges()[0].measurement.LocalCoordinates(expected).norm(), 1e-12);
}

TEST(Upright, NodesNeedPoses) {
  PoseGraph<SE3> graph;
  GraphNode<SE3> node;
  node.id = 7;
  node.has_pose = false;
  ASSERT_TRUE(graph.AddNode(node).ok());
  const Result<UprightGraph> upright = MakeUpright(graph, ErrorConvention::kG2o);
  EXPECT_EQ(upright.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(upright.status().message(), HasSubstr("node 7 has no pose"));
}

}  // namespace
}  // namespace hpgo
