#include "hpgo/update/window_step.h"

#include <string>

#include "gtest/gtest.h"
#include "hpgo/solve/block_solver.h"
#include "test/solve/small_graphs.h"
#include "test/solve/small_hierarchies.h"

namespace hpgo {
namespace {

constexpr float kPending = 7;
constexpr Index kPendingEdge = 3, kNewEdge = 5;

class WindowStepTest : public testing::Test {
 protected:
  WindowStepTest()
      : hierarchy_(MakeHierarchy(MakeKnownGraph<SE2>(12, 0.05, 1).graph, {})),
        step_(Engine::kBlock, &hierarchy_, [](Index e) { return std::to_string(e); }) {
    for (const Index e : {kPendingEdge, kNewEdge}) {
      hierarchy_.SetPending(0, e, kPending, thresholds_.pending);
    }
  }
  float Pending(Index e) const { return hierarchy_.level(0).edges[e].pending; }
  StepResult Solve(const WindowStep<SE2>::IsKnown& is_known) {
    EXPECT_TRUE(step_.window().BuildWhole(0, &hierarchy_));
    const auto solver = MakeBlockSolver<SE2>();
    return step_.SolveBy(solver.get(), {}, thresholds_, Budget(UpdateLimits()), is_known);
  }

  Hierarchy<SE2> hierarchy_;
  StressThresholds thresholds_ = StressThresholds::FromMean(1, 1e-3);
  WindowStep<SE2> step_;
};

TEST_F(WindowStepTest, ASolveIsDoneWithWhatWasPending) {
  EXPECT_GT(Solve({}).decrease, 0);
  EXPECT_LT(Pending(kPendingEdge), 0.1 * kPending);
  EXPECT_LT(Pending(kNewEdge), 0.1 * kPending);
}

TEST_F(WindowStepTest, AStepThatIsNoMinimumIsNot) {
  EXPECT_GT(Solve([](Index e) { return e != kNewEdge; }).decrease, 0);
  EXPECT_EQ(Pending(kPendingEdge), kPending);
  EXPECT_GT(Pending(kNewEdge), kPending);  // it has changed
}

}  // namespace
}  // namespace hpgo
