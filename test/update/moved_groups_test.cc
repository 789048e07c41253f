// A solve of everything moves the members of groups rigidly and far, and the groups' frames stay
// behind: what the levels above say is to be merged anew, though hardly an edge has changed.

#include <cmath>

#include "gtest/gtest.h"
#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/optimizer.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

SE2 MakePose(const SE2&, double x, double y, double turn) { return SE2(x, y, turn); }
SE3 MakePose(const SE3&, double x, double y, double turn) {
  return SE3(Eigen::Vector3d(x, y, 0),
             Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ())));
}

// Two grids whose edges do not quite fit, and a soft edge from one to the other.
template <typename G>
class TwoGrids {
 public:
  static constexpr int kSide = 12, kNodes = kSide * kSide;
  TwoGrids() : optimizer_(Options()) {
    for (int k = 0; k < 2 * kNodes; ++k) {
      const int in_grid = k % kNodes, x = in_grid % kSide, y = in_grid / kSide;
      EXPECT_TRUE(optimizer_.AddNode(k, At(x + k / kNodes * 2 * kSide, y, 0)).ok());
      if (x > 0) Tie(k - 1, k, At(1, 0.05 * std::sin(k), 0.05 * std::cos(3 * k)), 1e4);
      if (y > 0) Tie(k - kSide, k, At(0.05 * std::cos(k), 1, 0.05 * std::sin(2 * k)), 1e4);
      if (k == kNodes) Tie(0, k, At(2 * kSide, 0, 0), 1e-6);
      optimizer_.Update();
    }
    EXPECT_TRUE(optimizer_.Refine().at_rest);
  }
  // An edge that moves the second grid far as a whole, and turns it by so much.
  void MoveOne(double turn) { Tie(0, 2 * kNodes - 1, At(30, 20, turn), 1); }
  // Edges within it that do not fit either.
  void BringWork() {
    for (const int k : {kNodes + 3, kNodes + kNodes / 2}) {
      Tie(k, k + 5 * kSide + 2, At(2.2, 4.9, 0.1), 1e4);
    }
  }
  Optimizer<G>& optimizer() { return optimizer_; }

 private:
  static OptimizerOptions Options() {
    OptimizerOptions options;
    options.max_top_nodes = 20;
    options.window_nodes = 40;
    return options;
  }
  static G At(double x, double y, double turn) { return MakePose(G(), x, y, turn); }
  void Tie(NodeId i, NodeId j, const G& measurement, double weight) {
    const typename G::Matrix information = weight * G::Matrix::Identity();
    EXPECT_TRUE(optimizer_.AddEdge(i, j, measurement, information).ok());
  }

  Optimizer<G> optimizer_;
};

template <typename G>
class MovedGroupsTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(MovedGroupsTest, Groups);

TYPED_TEST(MovedGroupsTest, UpdatesAfterAWholeSolveDoNotRaiseTheCost) {
  for (const double turn : {0.4, 2.}) {  // 2: too far for anything but a solve of all nodes
    SCOPED_TRACE(turn);
    TwoGrids<TypeParam> grids;
    Optimizer<TypeParam>& optimizer = grids.optimizer();
    ASSERT_GT(optimizer.num_levels(), 2);
    grids.MoveOne(turn);
    ASSERT_TRUE(optimizer.Optimize(Mode::kFull).status.ok());
    for (int k = 0; k < 10; ++k) optimizer.Update();
    grids.BringWork();
    double before = optimizer.Cost();
    for (int k = 0; k < 30; ++k) {
      optimizer.Update();
      const double after = optimizer.Cost();
      ASSERT_LE(after, before * (1 + 1e-6)) << k;
      before = after;
    }
  }
}

}  // namespace
}  // namespace hpgo
