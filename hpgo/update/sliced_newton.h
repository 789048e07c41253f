// Newton steps of the whole of level 0, a slice an update.
#pragma once

#include <cstdint>
#include <type_traits>
#include <vector>

#include "hpgo/solve/simplified_newton.h"
#include "hpgo/update/schedules.h"

namespace hpgo {

// Where update after update gains much, the estimate is far from its optimum, and windows would
// need hundreds of updates for the last percents: what is left is smooth, and runs over the whole
// graph. Then level 0 is factored, a slice an update beside the windows; and steps are made with
// the factor as long as they gain much, then with the next one, of the Hessian from there, while
// windows still do. Holds the factor meanwhile, 5 KB a node in dense worlds of 10,000. Given up
// where anything else works on the whole graph: Refine, Converge, an update with a limit of time,
// one of another mode. Changes with every update. Not synchronized.
template <typename G>
class SlicedNewton {
 public:
  // Its work of one update.
  void DoSlice(const UpdateTools<G>& tools, const UpdatePlan& plan, UpdateReport* report);
  // What the windows of the update have come to: the next one begins to factor if this was one of
  // several that gained much. That is `far_off` where they solved as many nodes, on whatever level,
  // as level 0 has, and goes with the root of them below. At rest there is nothing left to do;
  // where most edges are in chains, such steps were seen to gain nothing.
  void Note(const ScheduleResult& windows, double far_off, const CondensedGraph<G>& graph);
  void Drop() { *this = SlicedNewton(); }

  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.updates_far_off_, self.stage_, self.slices_);
    if (self.stage_ < Stage::kFactoring) return;
    archive(self.known_, self.newton_);
    if constexpr (!std::is_const_v<Self>) self.is_loaded_ = true;
  }

 private:
  // A factor is spent once its steps, having gained much, do not any more.
  enum class Stage { kIdle, kWanted, kFactoring, kFactored, kStepping, kSpent };
  static bool BuildLevel(const UpdateTools<G>& tools);
  Stage Resume();
  Stage Begin(const UpdateTools<G>& tools);
  Stage Factor();
  Stage Step(const UpdateTools<G>& tools, const UpdatePlan& plan, UpdateReport* report);

  int updates_far_off_ = 0;  // in a row
  Stage stage_ = Stage::kIdle;
  int slices_ = 0;          // of the factorization
  bool is_loaded_ = false;  // from a saved state: to be factored again so far
  // By edge of level 0: those of the system, as their generations + 1; 0: none.
  std::vector<std::uint32_t> known_;
  SimplifiedNewton<G> newton_;
};

extern template class SlicedNewton<ceres_costs::SE2>;
extern template class SlicedNewton<ceres_costs::SE3>;
extern template class SlicedNewton<ceres_costs::YawPose>;

}  // namespace hpgo
