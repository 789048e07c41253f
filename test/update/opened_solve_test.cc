// What a solve with all chains opened leaves behind.

#include <atomic>
#include <memory>

#include "gtest/gtest.h"
#include "test/update/update_tools.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;

// Squared; sets a flag once it has been evaluated so often.
class Canceller : public ceres::LossFunction {
 public:
  Canceller(int evaluations, std::atomic<bool>* cancel) : left_(evaluations), cancel_(cancel) {}
  void Evaluate(double s, double rho[3]) const override {
    rho[0] = s;
    rho[1] = 1;
    rho[2] = 0;
    if (--left_ == 0) *cancel_ = true;
  }

 private:
  mutable int left_;
  std::atomic<bool>* cancel_;
};

class OpenedSolveTest : public testing::Test {
 protected:
  // A row of nodes a metre apart, each turned by so much against the one before it.
  static PoseGraph<SE2> Row(int nodes, double turn) {
    PoseGraph<SE2> graph;
    for (int k = 0; k < nodes; ++k) {
      const SE2 step(1, 0, turn);
      (void)graph.AddNode({k, k == 0 ? SE2() : graph.nodes()[k - 1].pose * step, false});
      if (k > 0) Add(k - 1, k, step, &graph);
    }
    return graph;
  }
  static void Add(int i, int j, const SE2& measurement, PoseGraph<SE2>* graph) {
    GraphEdge<SE2> edge;
    edge.i = i;
    edge.j = j;
    edge.measurement = measurement;
    edge.information = 100 * SE2::Matrix::Identity();
    (void)graph->AddEdge(edge);
  }
  // Cancelled when the closures have been evaluated so often.
  UpdateReport Solve(const PoseGraph<SE2>& graph, int evaluations) {
    cancel_ = false;
    update_ = std::make_unique<UpdateFixture<SE2>>(
        graph, OptimizerOptions(), std::make_shared<Canceller>(evaluations, &cancel_));
    UpdateLimits limits;
    limits.cancel = &cancel_;
    const Budget budget(limits);
    UpdateReport report;
    SolveOpened(update_->tools(), {budget, thresholds_, News(), 1e9}, 1e9, &report);
    return report;
  }

  // How often a solve of a graph whose closure gains without end has evaluated it.
  template <typename Solver>
  int EvaluationsOfEndless(const OptimizerOptions& options, const Solver& solve) {
    PoseGraph<SE2> graph = Row(20, 0.05);
    Add(5, 15, SE2(0, 10, 3), &graph);
    int evaluations = 0;
    UpdateFixture<SE2> update(graph, options, std::make_shared<EverOther>(0.99, &evaluations));
    const Budget budget{UpdateLimits()};
    solve(update.tools(), {budget, thresholds_, News(), 1e9});
    return evaluations;
  }

  const StressThresholds thresholds_ = StressThresholds::FromMean(1, 1e-4);
  std::atomic<bool> cancel_{false};
  std::unique_ptr<UpdateFixture<SE2>> update_;
};

// Nobody else would look where its linearizations still miss.
TEST_F(OpenedSolveTest, LeavesAllPendingWhereItWasCutShort) {
  PoseGraph<SE2> graph = Row(60, 0.05);
  Add(10, 40, SE2(0, 10, 3), &graph);
  Add(20, 59, SE2(0, 10, 3), &graph);
  const double to_the_end = Solve(graph, 1'000'000).cost_decrease;
  EXPECT_EQ(LargestPending(0, update_->hierarchy()), 0);
  const double decrease = Solve(graph, 10).cost_decrease;
  EXPECT_GT(decrease, 0);
  EXPECT_LT(decrease, 0.9 * to_the_end);
  // All, whatever its chain says of the one to the node that is held.
  EXPECT_GE(PendingEdges(thresholds_, update_->hierarchy()).size(), 5u);
}

// A chain is no model of edges that are turned further than a linearization reaches.
TEST_F(OpenedSolveTest, EdgesThatStayTurnedFarAreFreedOfTheirChain) {
  for (const double turn : {0.5, 3.}) {
    PoseGraph<SE2> graph = Row(4, 0);
    for (int k = 0; k < 2; ++k) Add(0, 3, SE2(0, 0, turn), &graph);
    EXPECT_GT(Solve(graph, 1'000'000).cost_decrease, 0);
    EXPECT_EQ(update_->hierarchy().level(0).num_nodes, 2);
    update_->graph().Restructure();
    EXPECT_EQ(update_->hierarchy().level(0).num_nodes, turn < 1 ? 2 : 4);
  }
}

// No limit of time cuts short that of an update.
TEST_F(OpenedSolveTest, EndsAfterSomeIterationsThoughItGains) {
  UpdateReport report;
  const int evaluations = EvaluationsOfEndless(
      OptimizerOptions(), [&](const UpdateTools<SE2>& tools, const UpdatePlan& plan) {
        SolveOpened(tools, plan, 1e9, &report);
      });
  EXPECT_GT(report.cost_decrease, 0);
  EXPECT_GT(evaluations, 200);
  EXPECT_LT(evaluations, 1000);
}

// Whole solves go on from there, with the chains linearized anew.
TEST_F(OpenedSolveTest, AWholeSolveTakesAsManyBetweenTwoLinearizationsOfChains) {
  UpdateReport report;
  const int evaluations = EvaluationsOfEndless(
      OptimizerOptions(), [&](const UpdateTools<SE2>& tools, const UpdatePlan& plan) {
        SolveWholeGraph(tools, plan, &report);
      });
  EXPECT_GT(evaluations, 1000);
}

// The paper's scheme optimizes the top fully, and no window after it gains as much.
TEST_F(OpenedSolveTest, SoDoesTheTopOfAFixedSchedule) {
  UpdateReport report;
  const int evaluations = EvaluationsOfEndless(
      OptimizerOptions::Paper(), [&](const UpdateTools<SE2>& tools, const UpdatePlan& plan) {
        RunFixedSchedule(tools, plan, kNone, &report);
      });
  EXPECT_EQ(report.top_solves, 1);
  EXPECT_GT(evaluations, 200);
  EXPECT_LT(evaluations, 1000);
}

// One that gains nothing is not cut short, however little time there is: it would be tried again
// for ever.
TEST_F(OpenedSolveTest, AWholeSolveWithoutTimeTellsThatItIsStuck) {
  PoseGraph<SE2> graph = Row(20, 0.05);
  Add(5, 15, SE2(0, 10, 3), &graph);
  for (const double factor : {0.99, 1e3}) {
    int evaluations = 0;
    UpdateFixture<SE2> update(graph, OptimizerOptions(),
                              std::make_shared<EverOther>(factor, &evaluations));
    UpdateLimits limits;
    limits.max_seconds = 1e-9;
    const Budget budget(limits);
    UpdateReport report;
    EXPECT_EQ(SolveWholeGraph(update.tools(), {budget, thresholds_, News(), 1e9}, &report),
              factor < 1 ? WholeSolve::kCutShort : WholeSolve::kStuck);
    EXPECT_EQ(report.cost_decrease > 0, factor < 1);
  }
}

// Nor is one stuck that has made its turns and still gains.
TEST_F(OpenedSolveTest, AWholeSolveWithoutAnEndIsCutShort) {
  PoseGraph<SE2> graph = Row(20, 0.05);
  Add(5, 15, SE2(0, 10, 3), &graph);
  int evaluations = 0;
  UpdateFixture<SE2> update(graph, OptimizerOptions(),
                            std::make_shared<EverOther>(1 - 1e-7, &evaluations));
  const Budget budget{UpdateLimits()};
  UpdateReport report;
  EXPECT_EQ(SolveWholeGraph(update.tools(), {budget, thresholds_, News(), 1e9}, &report),
            WholeSolve::kCutShort);
}

// Nor is one stuck that is cancelled before its first step.
TEST_F(OpenedSolveTest, AWholeSolveThatIsCancelledIsCutShort) {
  PoseGraph<SE2> graph = Row(20, 0.05);
  Add(5, 15, SE2(0, 10, 3), &graph);
  UpdateLimits limits;
  limits.cancel = &cancel_;
  UpdateReport report;
  for (int evaluations = 1; report.windows == 0; ++evaluations) {  // until the solve is the first
    cancel_ = false;
    UpdateFixture<SE2> update(graph, OptimizerOptions(),
                              std::make_shared<Canceller>(evaluations, &cancel_));
    const Budget budget(limits);
    EXPECT_EQ(SolveWholeGraph(update.tools(), {budget, thresholds_, News(), 1e9}, &report),
              WholeSolve::kCutShort);
  }
  EXPECT_EQ(report.cost_decrease, 0);
}

}  // namespace
}  // namespace hpgo
