// Jacobians through the user's manifold against differences, for each layout, lifted ones included.
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "ceres_costs/local_jacobian_cost.h"
#include "gtest/gtest.h"
#include "hpgo/ceres/adapted_cost.h"
#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/pose_system.h"
#include "hpgo/ceres/problem_view.h"
#include "hpgo/ceres/recognize_layout.h"
#include "hpgo/generate/synthetic_graph.h"
#include "test/ceres/mapper_problems.h"
#include "test/ceres_costs/cost_checks.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
PoseGraph<G> Graph() {
  GenerateOptions options;
  options.world = World::kManhattan;
  options.nodes = 30;
  options.closure_density = 0.5;
  options.noise_rotation = 0.05;
  return GenerateGraph<G>(options)->graph;
}

// The slope of the cost along the Gauss-Newton step.
template <typename Mapper, typename G>
void ExpectTrueGradient(Mapper mapper, const PoseGraph<G>& graph) {
  SCOPED_TRACE(MapperName(mapper));
  const auto made = MakeMapperProblem(mapper, graph);
  const ProblemView view(*made->problem);
  PoseBlocks poses;
  std::string reason;
  ASSERT_TRUE(FindPoseBlocks(view, {}, &poses, &reason)) << reason;
  const std::unique_ptr<PoseSystem> system = MakePoseSystem(view, poses);
  const double cost = system->Linearize();
  ASSERT_TRUE(std::isfinite(cost));
  ASSERT_TRUE(system->Factorize(1e-3));
  system->FindStep(1e-3);
  const double h = 1e-5;
  const double numeric = (system->Try(h) - system->Try(-h)) / (2 * h);
  EXPECT_NEAR(system->Slope(), numeric, 1e-5 * std::abs(numeric));
}

TEST(Jacobians, OfTheSystem) {
  for (const Mapper2d mapper : kMappers2d) ExpectTrueGradient(mapper, Graph<SE2>());
  for (const Mapper3d mapper : kMappers3d) ExpectTrueGradient(mapper, Graph<SE3>());
}

// Residuals and Jacobians of each cost over two poses, as a cost of the group.
template <typename G, typename Mapper, typename Measured>
void ExpectTrueJacobians(Mapper mapper, const PoseGraph<Measured>& graph) {
  SCOPED_TRACE(MapperName(mapper));
  const auto made = MakeMapperProblem(mapper, graph);
  const ProblemView view(*made->problem);
  PoseBlocks poses;
  PoseLayout layout;
  std::string reason;
  ASSERT_TRUE(FindPoseBlocks(view, {}, &poses, &reason)) << reason;
  ASSERT_TRUE(RecognizeLayout(view, poses, {}, &layout, &reason)) << reason;
  const PoseCodec<G> codec(layout);
  int checked = 0;
  for (const ResidualView& residual : view.residuals()) {
    const int first = poses.pose_of[view.BlockOf(residual, 0)];
    std::vector<BlockSource> sources;
    std::vector<int> over;
    for (int k = 0; k < residual.count; ++k) {
      const int b = view.BlockOf(residual, k);
      const int pose = poses.pose_of[b];
      BlockSource source;
      source.size = view.blocks()[b].size;
      source.values = view.blocks()[b].values;
      source.manifold = view.blocks()[b].manifold;
      source.true_jacobian =
          source.manifold == nullptr || HasTrueJacobian(*source.manifold, source.values);
      if (!view.blocks()[b].constant || pose == first) {
        std::size_t at = 0;
        while (at < over.size() && over[at] != pose) ++at;
        if (at == over.size()) over.push_back(pose);
        source.pose = static_cast<int>(at);
        for (int p = 0; poses.BlockOf(pose, p) != b; ++p) source.offset += layout.sizes[p];
      }
      sources.push_back(source);
    }
    if (over.size() > 2 || ++checked > 20) continue;
    const AdaptedCost<G> cost(residual.cost, codec, static_cast<int>(over.size()), sources);
    std::vector<G> X;
    for (const int pose : over) {
      std::vector<double> numbers;
      for (std::size_t k = 0; k < layout.sizes.size(); ++k) {
        const BlockView& block = view.blocks()[poses.BlockOf(pose, static_cast<int>(k))];
        numbers.insert(numbers.end(), block.values, block.values + block.size);
      }
      X.push_back(codec.Read(numbers.data()));
    }
    // The residuals are the user's own.
    std::vector<const double*> theirs;
    for (int k = 0; k < residual.count; ++k) {
      theirs.push_back(view.blocks()[view.BlockOf(residual, k)].values);
    }
    Eigen::VectorXd r(cost.num_residuals());
    ASSERT_TRUE(residual.cost->Evaluate(theirs.data(), r.data(), nullptr));
    EXPECT_LE((r - ceres_costs::Evaluate(cost, X).residuals).norm(), 1e-9 * (1 + r.norm()));
    ceres_costs::ExpectNumericJacobians(ceres_costs::LocalJacobianCost<G>(&cost), X, 1e-6);
  }
  EXPECT_GE(checked, 10);
}

TEST(Jacobians, OfAdaptedCosts) {
  for (const Mapper2d mapper : {Mapper2d::kCeresExample, Mapper2d::kCartographer}) {
    ExpectTrueJacobians<SE2>(mapper, Graph<SE2>());
  }
  for (const Mapper3d mapper :
       {Mapper3d::kCeresExample, Mapper3d::kVins6, Mapper3d::kFuse, Mapper3d::kOkvis,
        Mapper3d::kOv2slam, Mapper3d::kCovins, Mapper3d::kOpenLidarMap}) {
    ExpectTrueJacobians<SE3>(mapper, Graph<SE3>());
  }
  for (const Mapper3d mapper : {Mapper3d::kVins4, Mapper3d::kVoxgraph}) {
    ExpectTrueJacobians<YawPose>(mapper, Graph<SE3>());
  }
}

// The numbers of a pose, and back.
TEST(Jacobians, OfTheCodec) {
  for (const bool inverse : {false, true}) {
    for (const auto& [t, q] : {std::pair(0, 3), std::pair(4, 0)}) {
      for (const auto order : {PoseLayout::Quaternion::kWFirst, PoseLayout::Quaternion::kWLast}) {
        PoseLayout layout;
        layout.kind = PoseLayout::Kind::kXYZQuaternion;
        layout.direction =
            inverse ? PoseLayout::Direction::kNodeWorld : PoseLayout::Direction::kWorldNode;
        layout.quaternion = order;
        layout.translation_at = t;
        layout.rotation_at = q;
        const PoseCodec<SE3> codec(layout);
        SE3::Tangent d;
        d << 1, -2, 0.5, 0.3, 1.2, -0.7;
        const SE3 X = SE3().Retract(d);
        for (const double sign : {1., -1.}) {
          std::vector<double> values(7, 0.), plus(7), minus(7);
          codec.Write(X, values.data());
          if (sign < 0) {
            for (int k = 0; k < 4; ++k) values[q + k] *= -1;
            const std::vector<double> before = values;
            codec.Write(X, values.data());
            for (int k = 0; k < 7; ++k) EXPECT_NEAR(values[k], before[k], 1e-12);
          }
          EXPECT_LE(codec.Read(values.data()).LocalCoordinates(X).norm(), 1e-12);
          const auto J = codec.WriteJacobian(X, values.data());
          for (int c = 0; c < 6; ++c) {
            const double h = 1e-6;
            SE3::Tangent step = SE3::Tangent::Zero();
            step(c) = h;
            plus = minus = values;
            codec.Write(X.Retract(step), plus.data());
            codec.Write(X.Retract(-step), minus.data());
            for (int k = 0; k < 7; ++k) {
              EXPECT_NEAR(J(k, c), (plus[k] - minus[k]) / (2 * h), 1e-8) << k << " " << c;
            }
          }
        }
      }
    }
  }
  PoseLayout layout;
  layout.kind = PoseLayout::Kind::kXYTheta;
  layout.direction = PoseLayout::Direction::kNodeWorld;
  layout.angle = PoseLayout::AngleUnit::kDegrees;
  layout.translation_at = 1;
  layout.rotation_at = 0;
  const PoseCodec<SE2> codec(layout);
  const SE2 X(1, 2, 0.5);
  double values[3] = {720, 0, 0};
  codec.Write(X, values);
  EXPECT_NEAR(values[0], 720 - 0.5 * 180 / M_PI, 1e-9);  // as near as can be to what was there
  EXPECT_LE(codec.Read(values).LocalCoordinates(X).norm(), 1e-12);
  layout.kind = PoseLayout::Kind::kXYZYaw;
  const PoseCodec<YawPose> upright(layout);
  const YawPose Y(1, 2, 3, 0.5);
  double numbers[4] = {-720, 0, 0, 0};
  upright.Write(Y, numbers);
  EXPECT_NEAR(numbers[0], -720 - 0.5 * 180 / M_PI, 1e-9);
  EXPECT_NEAR(numbers[3], -3, 1e-12);
  EXPECT_LE(upright.Read(numbers).LocalCoordinates(Y).norm(), 1e-12);
}

}  // namespace
}  // namespace hpgo
