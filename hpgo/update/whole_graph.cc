// Solves of everything at once: over kept nodes, and of the graph as its caller sees it.
#include <algorithm>
#include <vector>

#include "hpgo/solve/solver_factory.h"
#include "hpgo/update/constants.h"
#include "hpgo/update/motion.h"
#include "hpgo/update/schedules.h"
#include "hpgo/update/updater.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// The graph without chains: every node that has an edge, held ones behind the free ones.
template <typename G>
class OpenedGraph {
 public:
  explicit OpenedGraph(CondensedGraph<G>* graph) : poses_(graph->end_of_nodes()) {
    std::vector<int> slots(graph->end_of_nodes(), kWorldFrame);
    std::vector<Index> held;
    const auto place = [&](Index n) {
      slots[n] = static_cast<int>(nodes_.size());
      nodes_.push_back(n);
      problem_.poses.push_back(poses_[n]);
    };
    graph->ForEachPose([&](Index n, const G& pose) {
      poses_[n] = pose;
      if (graph->Degree(n) == 0) return;
      if (graph->IsHeld(n)) {
        held.push_back(n);
      } else {
        place(n);
      }
    });
    problem_.num_free = static_cast<int>(nodes_.size());
    for (const Index n : held) place(n);
    for (Index e = 0; e < graph->end_of_edges(); ++e) {
      if (!graph->IsEdge(e)) continue;
      Factor<G> factor;
      static_cast<ceres_costs::FactorTerm<G>&>(factor) = graph->FactorOf(e);
      if (graph->End(e, 0) != kNone) factor.i = slots[graph->End(e, 0)];
      factor.j = slots[graph->End(e, 1)];
      problem_.factors.push_back(factor);
    }
  }

  Subproblem<G>* problem() { return &problem_; }
  // Before Poses.
  Motion LargestMoved() const {
    Motion largest;
    for (int k = 0; k < problem_.num_free; ++k) {
      largest = Larger(largest, MotionBetween(poses_[nodes_[k]], problem_.poses[k]));
    }
    return largest;
  }
  // T_world_node by node of the graph, where the problem has put them.
  const std::vector<G>& Poses() {
    for (std::size_t k = 0; k < nodes_.size(); ++k) poses_[nodes_[k]] = problem_.poses[k];
    return poses_;
  }

 private:
  std::vector<Index> nodes_;  // in the order of the problem's poses
  std::vector<G> poses_;
  Subproblem<G> problem_;
};

}  // namespace

template <typename G>
void SolveOpened(const UpdateTools<G>& tools, const UpdatePlan& plan, double max_seconds,
                 UpdateReport* report) {
  const Stopwatch watch(&report->window_seconds);
  CondensedGraph<G>& graph = tools.graph;
  OpenedGraph<G> opened(&graph);
  SubproblemOptions options;
  options.max_iterations = kFullIterations;
  options.max_seconds = std::min(options.max_seconds, max_seconds);
  options.cancel = plan.budget.cancel();
  const SubproblemSummary summary =
      MakeSolver<G>(tools.options.engine)->Solve(options, opened.problem());
  // What cannot be solved is told by the solves of the levels, which name the edge.
  const bool usable = summary.status.ok() || summary.status.code() == StatusCode::kInterrupted;
  if (!usable || !(summary.final_cost < summary.initial_cost)) return;
  ++report->windows;
  StepResult step;
  step.solved_nodes = opened.problem()->num_free;
  step.largest_moved = opened.LargestMoved();
  const std::vector<G>& poses = opened.Poses();
  graph.LinearizeChainsAt(poses);
  Window<G>& window = tools.step.window();
  if (window.BuildWhole(0, &graph.hierarchy(), false)) {
    for (int k = 0; k < window.num_free(); ++k) {
      window.subproblem().poses[k] = poses[graph.NodeOfLevel(window.nodes()[k])];
    }
    // Where it had to end before the optimum every edge is worth another look.
    tools.step.Take(summary.converged ? 0 : 2 * plan.thresholds.pending,
                    plan.thresholds.MergingAll(tools.options.coarse_edges));
  }
  step.decrease = summary.initial_cost - CostOf(&graph);
  Note(step, report);
}

template <typename G>
WholeSolve SolveWholeGraph(const UpdateTools<G>& tools, const UpdatePlan& plan,
                           UpdateReport* report) {
  const Stopwatch watch(&report->window_seconds);
  Hierarchy<G>& hierarchy = tools.graph.hierarchy();
  // Few at first where time may cut it short: a turn that gains nothing must end by itself, else
  // the next call would try it again.
  int iterations = plan.budget.HasTimeLimit() ? 1 : kFullIterations;
  for (int turn = 0; turn < kFullTurns; ++turn) {
    if (turn == 0 ? plan.budget.IsCancelled() : plan.budget.IsStopped()) {
      return WholeSolve::kCutShort;
    }
    if (turn > 0) tools.graph.SettleAll();
    if (!tools.step.window().BuildWhole(0, &hierarchy)) return WholeSolve::kConverged;
    ++report->windows;
    const StepResult step =
        tools.step.Solve(iterations, plan.budget.SecondsLeft(),
                         plan.thresholds.MergingAll(tools.options.coarse_edges), plan.budget);
    Note(step, report);
    if (!step.status.ok()) return WholeSolve::kStuck;
    if (plan.budget.IsCancelled()) return WholeSolve::kCutShort;
    const double rounding = kRoundingOfAFactor * hierarchy.level(0).num_edges;
    if (step.decrease > std::max(kFullStandstill * step.initial_cost, rounding)) {
      iterations = std::min(2 * iterations, kFullIterations);
    } else if (step.converged) {
      return WholeSolve::kConverged;
    } else if (iterations == 1) {
      return WholeSolve::kStuck;
    } else {
      iterations = 1;  // chains bend less on the way
    }
  }
  return WholeSolve::kCutShort;
}

#define HPGO_INSTANTIATE(G)                                                                   \
  template void SolveOpened(const UpdateTools<G>&, const UpdatePlan&, double, UpdateReport*); \
  template WholeSolve SolveWholeGraph(const UpdateTools<G>&, const UpdatePlan&, UpdateReport*);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
