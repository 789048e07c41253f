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

// Counts the groups of fields that are saved: the factor is one of its own.
struct Counter {
  template <typename... Values>
  void operator()(const Values&...) {
    ++groups;
  }
  int groups = 0;
};

class SlicedNewtonTest : public testing::Test {
 protected:
  bool HasFactor() const {
    Counter counter;
    SlicedNewton<SE3>::Fields(counter, newton_);
    return counter.groups > 1;
  }
  // What the windows of an update gain; more than 1 is much.
  void GainByWindows(double gain, UpdateFixture<SE3>* update, int covered = 1 << 20) {
    newton_.Note({false, gain, covered}, 1, update->hierarchy());
  }
  void DoSlice(UpdateFixture<SE3>* update) {
    const Budget budget{UpdateLimits()};
    const StressThresholds thresholds = StressThresholds::FromMean(1, 1e-3);
    UpdateReport report;
    newton_.DoSlice(update->tools(), {budget, thresholds, News(), 1e9}, &report);
  }
  void BeginIn(UpdateFixture<SE3>* update) {
    for (int k = 0; k < kUpdatesFarOff; ++k) GainByWindows(2, update);
    DoSlice(update);
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
  newton_.Note({true, 0, 0}, 1, update.hierarchy());
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

// Few nodes whose factor is nearly full would take as much memory as a large map.
TEST_F(SlicedNewtonTest, LargeFactorsAreNotBegun) {
  UpdateFixture<SE3> update(Ring(2500, 10'000));
  ASSERT_GT(update.hierarchy().num_levels(), 1);
  BeginIn(&update);
  EXPECT_FALSE(HasFactor());
}

}  // namespace
}  // namespace hpgo
