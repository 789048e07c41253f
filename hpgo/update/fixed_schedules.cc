#include <algorithm>
#include <limits>

#include "hpgo/update/constants.h"
#include "hpgo/update/schedules.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The groups of a level that hold an end of a new edge, as many as a window takes.
template <typename G>
std::vector<Index> GroupsOfNews(int l, const UpdateTools<G>& tools, const News& news) {
  const Hierarchy<G>& hierarchy = tools.graph.hierarchy();
  std::vector<Index> groups;
  for (const Index e : news.edges) {
    for (const Index end : hierarchy.level(0).edges[e].node) {
      if (static_cast<int>(groups.size()) >= tools.options.window_nodes) return groups;
      if (end == kNone) continue;
      const Index group = hierarchy.Ancestor(end, l);
      if (std::find(groups.begin(), groups.end(), group) == groups.end()) groups.push_back(group);
    }
  }
  return groups;
}

template <typename G>
std::vector<Index> SeedsOnLevel(int l, const UpdateTools<G>& tools, const News& news,
                                Index newest) {
  if (tools.options.schedule == Schedule::kNewEdges) return GroupsOfNews(l, tools, news);
  const Index kept = newest == kNone ? kNone : tools.graph.KeptNear(newest);
  if (kept == kNone) return {};
  return {tools.graph.hierarchy().Ancestor(tools.graph.LevelNodeOf(kept), l)};
}

}  // namespace

template <typename G>
void SolveTop(const UpdateTools<G>& tools, const UpdatePlan& plan, int iterations,
              UpdateReport* report) {
  const Stopwatch watch(&report->top_seconds);
  Hierarchy<G>& hierarchy = tools.graph.hierarchy();
  ++report->top_solves;
  if (!tools.step.window().BuildWhole(hierarchy.num_levels() - 1, &hierarchy)) return;
  Note(tools.step.Solve(iterations, kInfinity, plan.thresholds, plan.budget,
                        SeenCostOf(tools.graph, plan.may_rise)),
       report);
}

template <typename G>
void RunFixedSchedule(const UpdateTools<G>& tools, const UpdatePlan& plan, Index newest,
                      UpdateReport* report) {
  SolveTop(tools, plan, kFullIterations, report);
  const Stopwatch watch(&report->window_seconds);
  Hierarchy<G>& hierarchy = tools.graph.hierarchy();
  const SeenCost<G> seen = SeenCostOf(tools.graph, plan.may_rise);
  for (int l = hierarchy.num_levels() - 2; l >= 0 && !plan.budget.IsStopped(); --l) {
    const WindowLimits limits = {tools.options.window_nodes, tools.options.window_edges};
    if (!tools.step.window().Build(l, SeedsOnLevel(l, tools, plan.news, newest), limits,
                                   &hierarchy)) {
      continue;
    }
    ++report->windows;
    Note(tools.step.Solve(tools.options.window_iterations, kInfinity, plan.thresholds, plan.budget,
                          seen),
         report);
  }
}

#define HPGO_INSTANTIATE(G)                                                             \
  template void SolveTop(const UpdateTools<G>&, const UpdatePlan&, int, UpdateReport*); \
  template void RunFixedSchedule(const UpdateTools<G>&, const UpdatePlan&, Index, UpdateReport*);
HPGO_INSTANTIATE(SE2)
HPGO_INSTANTIATE(SE3)
HPGO_INSTANTIATE(YawPose)
#undef HPGO_INSTANTIATE

}  // namespace hpgo
