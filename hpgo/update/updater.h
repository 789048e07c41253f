// An update, from what is new to a better estimate.
#pragma once

#include <limits>
#include <vector>

#include "hpgo/update/chi2_mean.h"
#include "hpgo/update/far_closures.h"
#include "hpgo/update/gauge.h"
#include "hpgo/update/options.h"
#include "hpgo/update/schedules.h"
#include "hpgo/update/sliced_newton.h"

namespace hpgo {

// Works on a graph that somebody else owns. From one call to the next it keeps what it has learnt
// of the graph (the mean chi2, the time of windows) and how far it has got (the sweep, the slices,
// the depth of Refine); everything that a call decides is passed on inside it. Not synchronized.
template <typename G>
class Updater {
 public:
  Updater(const OptimizerOptions& options, CondensedGraph<G>* graph, LevelEdgeNamer name);

  // As of Optimizer, for the changes since the last call.
  UpdateReport Update(const Changes& changes, Mode mode, const UpdateLimits& limits,
                      Gauge<G>* gauge);
  UpdateReport Refine(const Changes& changes, const UpdateLimits& limits, Gauge<G>* gauge);
  UpdateReport Converge(const Changes& changes, const UpdateLimits& limits, Gauge<G>* gauge);

  // What it keeps.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.sizes_, self.sweep_, self.mean_, self.depth_, self.solved_at_depth_,
            self.mean_at_depth_, self.rest_, self.newton_, self.far_closures_);
  }

 private:
  struct Step {
    UpdateReport report;
    WholeSolve whole = WholeSolve::kStuck;  // of a full update
  };
  // Where the last call has left the graph.
  enum class Rest { kNot, kRefined, kOptimum };
  // What a call reports that has nothing to do.
  UpdateReport Unchanged() const;
  Step Run(const Changes& changes, Mode mode, const Budget& budget, double depth, Gauge<G>* gauge);
  Step RunWhole(const Changes& changes, const Budget& budget, Gauge<G>* gauge);
  void TakeIn(const Changes& changes, Gauge<G>* gauge, std::vector<Index>* disturbed);
  bool GoesByDegrees(Mode mode, const Changes& changes) const;
  std::vector<Index> Pull(bool by_degrees, const Changes& changes);
  ScheduleResult RunWindows(const UpdateTools<G>& tools, const UpdatePlan& plan,
                            UpdateReport* report);
  ScheduleResult RunByDegrees(const UpdateTools<G>& tools, const UpdatePlan& plan,
                              UpdateReport* report);
  bool IsMuch(const Changes& changes) const;
  bool IsToBeOpened(Mode mode, const Changes& changes, const UpdatePlan& plan) const;
  bool FitsWhole(const Changes& changes, const Budget& budget) const;
  void ResetDepth();
  StressThresholds Thresholds(double depth) const;
  G PoseOf(Index node) const { return node == kNone ? G() : graph_.WorldPose(node); }

  OptimizerOptions options_;
  CondensedGraph<G>& graph_;
  WindowStep<G> step_;
  WindowSizes sizes_;
  Sweep sweep_;
  Chi2Mean mean_;
  SlicedNewton<G> newton_;
  FarClosures<G> far_closures_;
  // How far Refine has got, in however many calls: it divides the stress threshold by the depth. At
  // this depth its windows have solved so many nodes; so much was the mean chi2 of all edges, those
  // in chains among them, when it was last at rest.
  double depth_ = 1, solved_at_depth_ = 0;
  double mean_at_depth_ = std::numeric_limits<double>::infinity();
  Rest rest_ = Rest::kNot;
};

// The sum of the losses of e' Omega e over all edges. O(edges).
template <typename G>
double CostOf(CondensedGraph<G>* graph);

extern template class Updater<ceres_costs::SE2>;
extern template class Updater<ceres_costs::SE3>;
extern template class Updater<ceres_costs::YawPose>;

}  // namespace hpgo
