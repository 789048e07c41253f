#include "hpgo/update/sliced_newton.h"

#include <random>

#include "gtest/gtest.h"
#include "hpgo/update/constants.h"
#include "test/solve/small_graphs.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

// A ring, and edges across it.
PoseGraph<SE3> Ring(int nodes, int across) {
  PoseGraph<SE3> graph;
  for (int k = 0; k < nodes; ++k) (void)graph.AddNode({k, SE3(), false});
  std::mt19937_64 rng(3);
  std::uniform_int_distribution<int> any(0, nodes - 1);
  GraphEdge<SE3> edge;
  edge.information = SE3::Matrix::Identity();
  for (int k = 0; k < nodes + across; ++k) {
    edge.i = k < nodes ? k : any(rng);
    edge.j = k < nodes ? (k + 1) % nodes : any(rng);
    if (edge.i != edge.j) (void)graph.AddEdge(edge);
  }
  return graph;
}

// Counts the groups of fields that are saved: the factor is one of its own. A loaded state factors
// as many slices again.
struct Counter {
  template <typename... Values>
  void operator()(const Values&...) {
    ++groups;
  }
  template <typename Updates, typename Stage>
  void operator()(const Updates&, const Stage&, const int& slices_so_far) {
    ++groups;
    slices = slices_so_far;
  }
  int groups = 0, slices = 0;
};

class SlicedNewtonTest : public testing::Test {
 protected:
  Counter Saved() const {
    Counter counter;
    SlicedNewton<SE3>::Fields(counter, newton_);
    return counter;
  }
  bool HasFactor() const { return Saved().groups > 1; }
  // What the windows of an update gain; more than 1 is much.
  void GainByWindows(double gain, UpdateFixture<SE3>* update, int covered = 1 << 20) {
    newton_.Note({false, gain, covered}, 1, update->graph());
  }
  // Whether it made a step.
  bool DoSlice(UpdateFixture<SE3>* update) {
    const Budget budget{UpdateLimits()};
    const StressThresholds thresholds = StressThresholds::FromMean(1, 1e-3);
    UpdateReport report;
    newton_.DoSlice(update->tools(), {budget, thresholds, News(), 1e9}, &report);
    return report.windows > 0;
  }
  void BeginIn(UpdateFixture<SE3>* update) {
    for (int k = 0; k < kUpdatesFarOff; ++k) GainByWindows(2, update);
    DoSlice(update);
  }

  // To the first step; the slices before it.
  int DoSlicesToStep(UpdateFixture<SE3>* update) {
    int slices = 0;
    for (; slices < 100 && !DoSlice(update); ++slices) GainByWindows(0, update);
    return slices;
  }

  SlicedNewton<SE3> newton_;
};

TEST_F(SlicedNewtonTest, IsGivenUpAtRest) {
  UpdateFixture<SE3> update(Ring(2500, 1000));
  BeginIn(&update);
  EXPECT_TRUE(HasFactor());
  GainByWindows(0, &update);
  DoSlice(&update);
  EXPECT_TRUE(HasFactor());
  newton_.Note({true, 0, 0}, 1, update.graph());
  EXPECT_FALSE(HasFactor());
}

TEST_F(SlicedNewtonTest, AFactorTakesSeveralUpdates) {
  UpdateFixture<SE3> update(Ring(2500, 1000));
  BeginIn(&update);
  EXPECT_GE(DoSlicesToStep(&update), 2);
}

// Its Hessian was that of an estimate far away, which another one need not be.
TEST_F(SlicedNewtonTest, ASpentFactorIsFollowedByAnotherWhileWindowsGainMuch) {
  PoseGraph<SE3> graph = Ring(700, 300);
  GraphEdge<SE3> pull;
  pull.i = 0;
  pull.j = 350;
  pull.measurement = SE3(SE3::Vector(10, 0, 0), SE3::Quaternion::Identity());
  pull.information = SE3::Matrix::Identity();
  ASSERT_TRUE(graph.AddEdge(pull).ok());
  for (const double gain : {0., 2.}) {
    UpdateFixture<SE3> update(graph);
    newton_.Drop();
    BeginIn(&update);
    DoSlicesToStep(&update);  // gains nearly all of it
    GainByWindows(gain, &update);
    EXPECT_TRUE(HasFactor());
    EXPECT_TRUE(DoSlice(&update));  // gains next to nothing
    GainByWindows(gain, &update);
    EXPECT_FALSE(DoSlice(&update));
    EXPECT_EQ(HasFactor(), gain > 0);
    EXPECT_EQ(Saved().slices, 0);
  }
}

// A closure at the optimum of level 0 is none of its business.
TEST_F(SlicedNewtonTest, AFactorThatGainsNothingIsFollowedByNone) {
  UpdateFixture<SE3> update(Ring(700, 300));
  BeginIn(&update);
  DoSlicesToStep(&update);
  GainByWindows(2, &update);
  EXPECT_FALSE(HasFactor());
  EXPECT_FALSE(DoSlice(&update));
  EXPECT_FALSE(HasFactor());
}

// In large maps the windows of an update cover little, and gain as little.
TEST_F(SlicedNewtonTest, BeginsByWhatIsGainedForWhatIsCovered) {
  UpdateFixture<SE3> update(Ring(2500, 1000));
  const int nodes = update.hierarchy().level(0).num_nodes;
  const auto begins = [&](double gain, int covered) {
    for (int k = 0; k < kUpdatesFarOff; ++k) GainByWindows(gain, &update, covered);
    DoSlice(&update);
    return HasFactor();
  };
  EXPECT_FALSE(begins(0.6, nodes));
  EXPECT_FALSE(begins(0.4, nodes / 4));
  EXPECT_TRUE(begins(0.6, nodes / 4));
}

// Chains that hold most of the edges do not follow a step of all of level 0.
TEST_F(SlicedNewtonTest, ChainLikeMapsAreLeftToWindows) {
  UpdateFixture<SE3> chains(Ring(2500, 300)), dense(Ring(700, 300));
  BeginIn(&chains);
  EXPECT_FALSE(HasFactor());
  BeginIn(&dense);
  EXPECT_TRUE(HasFactor());
}

// Few nodes whose factor is nearly full would take as much memory as a large map.
TEST_F(SlicedNewtonTest, LargeFactorsAreNotBegun) {
  UpdateFixture<SE3> update(Ring(2500, 10'000));
  ASSERT_GT(update.hierarchy().num_levels(), 1);
  BeginIn(&update);
  EXPECT_FALSE(HasFactor());
}

}  // namespace
}  // namespace hpgo
