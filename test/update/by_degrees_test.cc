// Updates that take in a closure that is far off by degrees, and those that do not.

#include "gtest/gtest.h"
#include "hpgo/update/constants.h"
#include "hpgo/update/updater.h"
#include "test/update/ladder.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

constexpr int kLength = 401;

OptimizerOptions SmallTop() {
  OptimizerOptions options;
  options.max_top_nodes = 20;
  return options;
}

// The ladder, all of it at rest, and an updater.
template <typename G>
class Map {
 public:
  explicit Map(int rungs = kRungs, const OptimizerOptions& options = SmallTop(), int tail = kTail)
      : last_(2 * kLength + tail - 1),
        update_(Ladder<G>(kLength, rungs, tail), options),
        updater_(options, &update_.graph(), [](Index e) { return std::to_string(e); }) {
    gauge_.SetFixed(0, true, &graph());
    Update();
  }

  CondensedGraph<G>& graph() { return update_.graph(); }
  // The end of the tail is said to stand so much elsewhere; one of so many changes.
  UpdateReport Close(const G& off, int changes = 1, Mode mode = Mode::kPartial,
                     int rung = 10 * kRungs) {
    const G T_rung_last = graph().WorldPose(rung).Between(graph().WorldPose(last_));
    Changes closure = Changes::None(last_);
    closure.edges = {graph().AddEdge(rung, last_, Measuring<G>(T_rung_last * off))};
    closure.num_edges = changes;
    return updater_.Update(closure, mode, {}, &gauge_);
  }
  UpdateReport Update(Mode mode = Mode::kPartial) {
    return updater_.Update(Changes::None(last_), mode, {}, &gauge_);
  }
  UpdateReport Refine() { return updater_.Refine(Changes::None(last_), {}, &gauge_); }
  UpdateReport Converge() { return updater_.Converge(Changes::None(last_), {}, &gauge_); }
  bool IsUnderWay() { return !graph().pulled().empty(); }
  int DegreesOfFirstUpdate() { return kMostDegrees - graph().pulled().begin()->second.pull.left; }

 private:
  Index last_;
  UpdateFixture<G> update_;
  Gauge<G> gauge_;
  Updater<G> updater_;
};

template <typename G>
class ByDegreesTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(ByDegreesTest, Groups);

constexpr double kFar = 2;  // rad

TYPED_TEST(ByDegreesTest, AClosureIsUnderWayForSomeUpdatesAndEndsAtTheOptimum) {
  Map<TypeParam> map, full;
  UpdateReport report = map.Close(Ahead<TypeParam>(0, kFar));
  EXPECT_TRUE(map.IsUnderWay());
  EXPECT_FALSE(report.at_rest);
  for (int k = 0; k < 100 && !report.at_rest; ++k) report = map.Update();
  EXPECT_TRUE(report.at_rest);
  EXPECT_FALSE(map.IsUnderWay());
  map.Refine();
  map.Converge();
  full.Close(Ahead<TypeParam>(0, kFar), 1, Mode::kFull);
  full.Converge();
  EXPECT_NEAR(CostOf(&map.graph()), CostOf(&full.graph()), 1e-4 * CostOf(&full.graph()));
}

TYPED_TEST(ByDegreesTest, AnUpdateGoesOnByAFewDegrees) {
  Map<TypeParam> map;
  map.Close(Ahead<TypeParam>(0, kFar));
  ASSERT_TRUE(map.IsUnderWay());
  EXPECT_GT(map.DegreesOfFirstUpdate(), 1);
  EXPECT_LE(map.DegreesOfFirstUpdate(), kRoundsOfAnUpdate);
}

// Few nodes around it are few metres, which a long tail takes up in no time.
TYPED_TEST(ByDegreesTest, NorByMoreWhereEachIsSoonOver) {
  OptimizerOptions options = SmallTop();
  options.window_nodes = 5;
  options.max_windows = 20;
  Map<TypeParam> map(kRungs, options);
  map.Close(Aside<TypeParam>(30));
  ASSERT_TRUE(map.IsUnderWay());
  EXPECT_EQ(map.DegreesOfFirstUpdate(), kRoundsOfAnUpdate);
}

TYPED_TEST(ByDegreesTest, NorWhereOneLinearizesALongChainAgainAndAgain) {
  OptimizerOptions options = SmallTop();
  options.window_nodes = 20;
  options.max_windows = 1;
  Map<TypeParam> map(kRungs, options, 500);
  map.Close(Ahead<TypeParam>(0, 1));
  ASSERT_TRUE(map.IsUnderWay());
  EXPECT_EQ(map.DegreesOfFirstUpdate(), 1);
}

// Both ends are in one group: no level above tells of it that it pulls on.
TYPED_TEST(ByDegreesTest, SoDoesAClosureThatOnlyLevelZeroSees) {
  constexpr int kBeginOfTail = 2 * kLength - 1;
  for (const double ahead : {0, 10}) {
    Map<TypeParam> map, full;
    UpdateReport report = map.Close(Ahead<TypeParam>(ahead, 1), 1, Mode::kPartial, kBeginOfTail);
    for (int k = 0; k < 20 && !report.at_rest; ++k) report = map.Update();
    EXPECT_TRUE(report.at_rest);
    full.Close(Ahead<TypeParam>(ahead, 1), 1, Mode::kFull, kBeginOfTail);
    full.Converge();
    EXPECT_NEAR(CostOf(&map.graph()), CostOf(&full.graph()), 1e-3 * CostOf(&full.graph()));
  }
}

TYPED_TEST(ByDegreesTest, RefineGoesAllTheWay) {
  Map<TypeParam> map;
  map.Close(Ahead<TypeParam>(3, 1));
  ASSERT_TRUE(map.IsUnderWay());
  EXPECT_TRUE(map.Refine().at_rest);
  EXPECT_FALSE(map.IsUnderWay());
}

TYPED_TEST(ByDegreesTest, AFullSolveTakesInAllThatIsUnderWay) {
  Map<TypeParam> map;
  map.Close(Ahead<TypeParam>(0, kFar));
  ASSERT_TRUE(map.IsUnderWay());
  map.Update(Mode::kFull);
  EXPECT_FALSE(map.IsUnderWay());
}

// Of much that is new each would take its own way.
TYPED_TEST(ByDegreesTest, MuchAtOnceIsTakenInAtOnce) {
  Map<TypeParam> map;
  map.Close(Ahead<TypeParam>(0, kFar), map.graph().num_edges() / 5);
  EXPECT_FALSE(map.IsUnderWay());
}

// All kept nodes are solved at once.
TYPED_TEST(ByDegreesTest, OneLevelTakesItInAtOnce) {
  Map<TypeParam> map(kRungs, {});
  ASSERT_EQ(map.graph().hierarchy().num_levels(), 1);
  map.Close(Ahead<TypeParam>(0, kFar));
  EXPECT_FALSE(map.IsUnderWay());
}

// What is solved with it holds it better than a chain does.
TYPED_TEST(ByDegreesTest, DenseMapsTakeItInAtOnce) {
  Map<TypeParam> map(1);
  map.Close(Ahead<TypeParam>(0, kFar));
  EXPECT_FALSE(map.IsUnderWay());
}

TYPED_TEST(ByDegreesTest, SoDoFixedSchedules) {
  OptimizerOptions options = SmallTop();
  options.schedule = Schedule::kNewEdges;
  Map<TypeParam> map(kRungs, options);
  map.Close(Ahead<TypeParam>(0, kFar));
  EXPECT_FALSE(map.IsUnderWay());
}

}  // namespace
}  // namespace hpgo
