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

OptimizerOptions SmallTop() {
  OptimizerOptions options;
  options.max_top_nodes = 20;
  return options;
}

// The ladder, all of it at rest, and an updater.
template <typename G>
class Map {
 public:
  explicit Map(int length, int rungs = kRungs, int tail = kTail,
               const OptimizerOptions& options = SmallTop())
      : last_(2 * length + tail - 1),
        update_(Ladder<G>(length, rungs, tail), options),
        updater_(options, &update_.graph(), [](Index e) { return std::to_string(e); }) {
    gauge_.SetFixed(0, true, &graph());
    Update(Changes::None(last_));
  }

  CondensedGraph<G>& graph() { return update_.graph(); }
  // The end of the tail is said to be turned so far; as one of many changes.
  UpdateReport Close(double turn, int changes = 1, Mode mode = Mode::kPartial,
                     const UpdateLimits& limits = {}) {
    const int rung = 10 * kRungs;
    EdgeData<G> data;
    data.term = {graph().WorldPose(rung).Between(graph().WorldPose(last_)) * Ahead<G>(0, turn),
                 ceres_costs::PackedSymmetric<G::kDof>((1e4 * G::Matrix::Identity()).eval())};
    Changes closure = Changes::None(last_);
    closure.edges = {graph().AddEdge(rung, last_, data)};
    closure.num_edges = changes;
    return Update(closure, mode, limits);
  }
  UpdateReport Update(const Changes& changes, Mode mode = Mode::kPartial,
                      const UpdateLimits& limits = {}) {
    return updater_.Update(changes, mode, limits, &gauge_);
  }
  UpdateReport Refine() { return updater_.Refine(Changes::None(last_), {}, &gauge_); }
  UpdateReport Converge() { return updater_.Converge(Changes::None(last_), {}, &gauge_); }
  Changes Nothing() const { return Changes::None(last_); }
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
constexpr int kLength = 401;

TYPED_TEST(ByDegreesTest, AClosureIsUnderWayForSomeUpdatesAndEndsAtTheOptimum) {
  Map<TypeParam> map(kLength), full(kLength);
  UpdateReport report = map.Close(kFar);
  EXPECT_TRUE(map.IsUnderWay());
  EXPECT_FALSE(report.at_rest);
  for (int k = 0; k < 100 && !report.at_rest; ++k) report = map.Update(map.Nothing());
  EXPECT_TRUE(report.at_rest);
  EXPECT_FALSE(map.IsUnderWay());
  map.Refine();
  map.Converge();
  full.Close(kFar, 1, Mode::kFull);
  full.Converge();
  EXPECT_NEAR(CostOf(&map.graph()), CostOf(&full.graph()), 1e-4 * CostOf(&full.graph()));
}

TYPED_TEST(ByDegreesTest, AnUpdateGoesOnByAFewDegrees) {
  Map<TypeParam> map(kLength);
  map.Close(kFar);
  ASSERT_TRUE(map.IsUnderWay());
  EXPECT_GT(map.DegreesOfFirstUpdate(), 1);
  EXPECT_LE(map.DegreesOfFirstUpdate(), kRoundsOfAnUpdate);
}

TYPED_TEST(ByDegreesTest, RefineGoesAllTheWay) {
  Map<TypeParam> map(kLength);
  map.Close(1);
  ASSERT_TRUE(map.IsUnderWay());
  EXPECT_TRUE(map.Refine().at_rest);
  EXPECT_FALSE(map.IsUnderWay());
}

TYPED_TEST(ByDegreesTest, AFullSolveTakesInAllThatIsUnderWay) {
  Map<TypeParam> map(kLength);
  map.Close(kFar);
  ASSERT_TRUE(map.IsUnderWay());
  map.Update(map.Nothing(), Mode::kFull);
  EXPECT_FALSE(map.IsUnderWay());
}

// Of much that is new each would take its own way.
TYPED_TEST(ByDegreesTest, MuchAtOnceIsTakenInAtOnce) {
  Map<TypeParam> map(kLength);
  map.Close(kFar, map.graph().num_edges() / 5);
  EXPECT_FALSE(map.IsUnderWay());
}

// All kept nodes are solved at once.
TYPED_TEST(ByDegreesTest, OneLevelTakesItInAtOnce) {
  Map<TypeParam> map(kLength, kRungs, kTail, {});
  ASSERT_EQ(map.graph().hierarchy().num_levels(), 1);
  map.Close(kFar);
  EXPECT_FALSE(map.IsUnderWay());
}

// What is solved with it holds it better than a chain does.
TYPED_TEST(ByDegreesTest, DenseMapsTakeItInAtOnce) {
  Map<TypeParam> map(kLength, 1);
  map.Close(kFar);
  EXPECT_FALSE(map.IsUnderWay());
}

TYPED_TEST(ByDegreesTest, SoDoFixedSchedules) {
  OptimizerOptions options = SmallTop();
  options.schedule = Schedule::kNewEdges;
  Map<TypeParam> map(kLength, kRungs, kTail, options);
  map.Close(kFar);
  EXPECT_FALSE(map.IsUnderWay());
}

}  // namespace
}  // namespace hpgo
