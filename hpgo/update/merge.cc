#include "hpgo/update/constants.h"
#include "hpgo/update/schedules.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
void MergeDirty(const UpdateTools<G>& tools, const UpdatePlan& plan, UpdateReport* report) {
  const Stopwatch watch(&report->merge_seconds);
  Hierarchy<G>& hierarchy = tools.graph.hierarchy();
  const auto goes_on = [&](std::size_t k) {
    if (!plan.budget.IsUncapped()) return report->merged_edges < tools.options.max_merges;
    // A few are made in any time: what is dirty holds up the windows.
    return report->merged_edges == 0 || k % kMergesPerLookAtClock != 0 || !plan.budget.IsStopped();
  };
  for (int l = 1; l < hierarchy.num_levels(); ++l) {
    Level<G>& level = hierarchy.mutable_level(l);
    std::size_t k = 0;
    for (; k < level.dirty.size() && goes_on(k); ++k) {
      const Index e = level.dirty[k];
      level.edges[e].dirty = false;
      if (!level.edges[e].alive) continue;
      const double change = hierarchy.Merge(l, e);
      ++report->merged_edges;
      AddPending(l, e, change, plan.thresholds, &hierarchy);
      TellParent(l, e, change, plan.thresholds, &hierarchy);
    }
    level.dirty.erase(level.dirty.begin(), level.dirty.begin() + static_cast<std::ptrdiff_t>(k));
    if (l == 1) QueueRefreshed(plan.thresholds, &hierarchy);
  }
}

template void MergeDirty(const UpdateTools<SE2>&, const UpdatePlan&, UpdateReport*);
template void MergeDirty(const UpdateTools<SE3>&, const UpdatePlan&, UpdateReport*);
template void MergeDirty(const UpdateTools<YawPose>&, const UpdatePlan&, UpdateReport*);

}  // namespace hpgo
