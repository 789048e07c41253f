// Faults that users met, each as the right behaviour.

#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "ceres/loss_function.h"
#include "gtest/gtest.h"
#include "hpgo/hierarchy/consistency.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class FaultsTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(FaultsTest, Groups);

// What the scheduler knows is a number: a NaN is never looked at again.
template <typename G>
int CountBadBookkeeping(const Hierarchy<G>& hierarchy) {
  int bad = 0;
  for (int l = 0; l < hierarchy.num_levels(); ++l) {
    const Level<G>& level = hierarchy.level(l);
    for (Index e = 0; e < static_cast<Index>(level.edges.size()); ++e) {
      const LevelEdge& edge = level.edges[e];
      bad += edge.alive && !(edge.pending >= 0 && edge.changed >= 0);
    }
  }
  return bad;
}

// Rounding makes the chi2 of a satisfied edge of rank one negative about every second time.
TYPED_TEST(FaultsTest, RoundingBelowZeroIsZero) {
  using G = TypeParam;
  std::mt19937_64 rng(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int looked_at = 0;
  for (int k = 0; k < 500; ++k) {
    typename G::Tangent v;
    for (int d = 0; d < G::kDof; ++d) v(d) = 30 * uniform(rng);
    const typename G::Matrix rank_one = v * v.transpose();
    const G step = RandomPose<G>(&rng, 3, 1);
    Optimizer<G> optimizer;
    ASSERT_TRUE(optimizer.AddNode(0, RandomPose<G>(&rng, 3, 1)).ok());
    ASSERT_TRUE(
        optimizer.AddNode(1, *optimizer.GetPose(0) * step * RandomPose<G>(&rng, 0.1, 0.1)).ok());
    const EdgeId edge = *optimizer.AddEdge(0, 1, step, rank_one);
    optimizer.Refine();
    ASSERT_TRUE(optimizer.UpdateEdge(edge, step, rank_one).ok());
    optimizer.Update();
    ASSERT_GE(optimizer.Cost(), 0);
    ASSERT_GE(optimizer.GetEdgeError(edge)->chi2, 0);
    ASSERT_EQ(CountBadBookkeeping(optimizer.hierarchy()), 0);
    ASSERT_TRUE(optimizer.SetPose(1, *optimizer.GetPose(1) * RandomPose<G>(&rng, 1, 0.3)).ok());
    looked_at += optimizer.Update().examined_edges > 0;
    ASSERT_EQ(CountBadBookkeeping(optimizer.hierarchy()), 0);
    ASSERT_TRUE(optimizer.Refine().at_rest);
  }
  EXPECT_EQ(looked_at, 500);
}

// A cost whose square overflows: refused where a value says so, else reported; Refine ends.
TYPED_TEST(FaultsTest, RefineEndsWhereTheCostIsHuge) {
  using G = TypeParam;
  Optimizer<G> optimizer;
  G far;
  far.translation()(0) = 1e49;
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(optimizer.AddNode(k, k % 2 == 0 ? G() : far).ok());
  for (int k = 0; k < 6; ++k) {
    for (int j = 0; j < k; ++j) {
      ASSERT_TRUE(optimizer.AddEdge(j, k, far, G::Matrix::Identity() * std::pow(1e20, j % 3)).ok());
    }
  }
  optimizer.Refine();
  optimizer.Optimize(Mode::kFull);
  optimizer.Refine();
  EXPECT_EQ(CountBadBookkeeping(optimizer.hierarchy()), 0);
  EXPECT_EQ(FindInconsistency(optimizer.hierarchy()), "");
}

class Infinite : public ceres::LossFunction {
 public:
  void Evaluate(double s, double rho[3]) const override {
    rho[0] = s > 1 ? std::numeric_limits<double>::infinity() : s;
    rho[1] = 1;
    rho[2] = 0;
  }
};

TYPED_TEST(FaultsTest, RefineEndsWhereTheCostIsInfinite) {
  using G = TypeParam;
  Optimizer<G> optimizer;
  const auto loss = std::make_shared<Infinite>();
  G step;
  step.translation()(0) = 5;
  for (int k = 0; k < 40; ++k) ASSERT_TRUE(optimizer.AddNode(k, G()).ok());
  for (int k = 1; k < 40; ++k) {
    const auto with = k == 20 ? loss : nullptr;
    ASSERT_TRUE(optimizer.AddEdge(k - 1, k, step, G::Matrix::Identity(), with).ok());
  }
  const UpdateReport report = optimizer.Refine();
  EXPECT_TRUE(report.at_rest || !report.status.ok());
  EXPECT_EQ(CountBadBookkeeping(optimizer.hierarchy()), 0);
}

TYPED_TEST(FaultsTest, ANegativeLimitVisitsEveryNodeOnce) {
  using G = TypeParam;
  OptimizerOptions options;
  options.max_top_nodes = 4;
  Optimizer<G> optimizer(options);
  std::map<NodeId, int> visits;
  const auto visit_all = [&] {
    visits.clear();
    optimizer.ForEachMoved(-1, -1, [&](NodeId id, const G&) { ++visits[id]; });
    EXPECT_EQ(visits.size(), optimizer.num_nodes());
    for (const auto& [id, count] : visits) EXPECT_EQ(count, 1) << id;
  };
  const KnownGraph<G> known = MakeKnownGraph<G>(40, 0.1, 3);
  ASSERT_TRUE(optimizer.AddGraph(known.graph).ok());
  optimizer.Update();
  EXPECT_GE(optimizer.num_levels(), 3);
  visit_all();
  visit_all();
  // Nodes that no group has yet; a place that is used again waits twice.
  for (const NodeId id : {100, 101}) ASSERT_TRUE(optimizer.AddNode(id, G()).ok());
  ASSERT_TRUE(optimizer.RemoveNode(101).ok());
  ASSERT_TRUE(optimizer.AddNode(102, G()).ok());
  ASSERT_TRUE(optimizer.AddEdge(100, 102, G(), G::Matrix::Identity()).ok());
  ASSERT_TRUE(optimizer.RemoveNode(5).ok());
  visit_all();
  optimizer.Update();
  visit_all();
  // A new node, and at once at the end of a chain that is looked at as well.
  ASSERT_TRUE(optimizer.AddNode(103, G()).ok());
  ASSERT_TRUE(optimizer.AddEdge(102, 103, G(), G::Matrix::Identity()).ok());
  optimizer.Update();
  visit_all();
}

// Values that were found out only when some nodes stood in the optimizer.
TYPED_TEST(FaultsTest, AddGraphLeavesNothingOfAGraphThatItRefuses) {
  using G = TypeParam;
  const KnownGraph<G> known = MakeKnownGraph<G>(3, 0.1, 3);
  G far;
  far.translation()(0) = 9e49;
  const auto refused = [&](const PoseGraph<G>& graph) {
    Optimizer<G> optimizer;
    const Status status = optimizer.AddGraph(graph);
    EXPECT_EQ(optimizer.num_nodes(), 0u);
    EXPECT_EQ(optimizer.num_edges(), 0u);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    return status.message();
  };
  PoseGraph<G> graph = known.graph;
  for (int k = 1; k < 3; ++k) graph.node(k).has_pose = false;
  for (int k = 0; k < 2; ++k) graph.edge(k).measurement = far;
  EXPECT_EQ(refused(graph), "node 2: the composed pose is too large");
  graph = known.graph;
  graph.edge(1).measurement = far * far;
  EXPECT_EQ(refused(graph), "edge 1 -> 2: the measurement is too large");
}

// However long a quaternion is, it says where it points.
TEST(FaultsTest3d, LongQuaternionsAreNormalized) {
  KnownGraph<SE3> known = MakeKnownGraph<SE3>(3, 0.1, 3);
  for (const double length : {1e-6, 1e160}) {
    known.graph.node(2).pose.rotation().coeffs() *= length;
    Optimizer3d optimizer;
    ASSERT_TRUE(optimizer.AddGraph(known.graph).ok());
    EXPECT_NEAR(optimizer.GetPose(2)->rotation().norm(), 1, 1e-12);
    known.graph.node(2).pose = *optimizer.GetPose(2);
  }
}

}  // namespace
}  // namespace hpgo
