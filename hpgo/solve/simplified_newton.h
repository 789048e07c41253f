// The simplified Newton method: one Hessian, factored in shares, for many steps.
#pragma once

#include <cstdint>
#include <vector>

#include "hpgo/hierarchy/level.h"
#include "hpgo/solve/block_system.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// For problems that are too large to be factored at once and that go on changing meanwhile. The
// Hessian is that of the estimate where it began; as it is in the frames of the poses, it hardly
// depends on where they stand, but on the shape of what they form. The gradient of every step is
// that of the moment. So a step is never wrong, only less good the more has changed: it descends,
// and is taken only if the cost falls.
//
// Poses have names, by which they are found again in a later problem. Not synchronized.
template <typename G>
class SimplifiedNewton : public SubproblemSolver<G> {
 public:
  using Progress = typename BlockCholesky<G::kDof>::Progress;

  // Orders and linearizes a problem at its poses; names[k] is that of pose k, not negative. False
  // if a cost cannot be evaluated.
  bool Begin(const Subproblem<G>& problem, const std::vector<Index>& names);
  // Factors on; see BlockCholesky::GoOn.
  Progress GoOn(double multiplications) { return system_.GoOnFactorizing(multiplications); }

  // The names in the next problem that is solved. Borrowed.
  void SetNames(const std::vector<Index>* names) { names_ = names; }
  // One step, once the factor is done, no longer than turns of kReach. Of the options only
  // `cancel` counts. Free poses that were not there when it began follow a neighbour rigidly; where
  // nothing ties them to one, they stay.
  SubproblemSummary Solve(const SubproblemOptions& options, Subproblem<G>* problem) override;

  // Numbers in the factor.
  std::int64_t factor_size() const { return system_.factor_size(); }

  // A saved state has what it begins from. Loaded, it is to be resumed, and has factored nothing.
  template <typename Archive, typename Self>
  static void Fields(Archive& archive, Self& self) {
    archive(self.num_slots_, self.slot_of_name_, self.system_);
  }
  // False if what was loaded makes no sense.
  bool Resume();

 private:
  using Tangent = typename G::Tangent;

  bool FindSlots(const Subproblem<G>& problem);
  double FindStep(const Subproblem<G>& problem, double* promised);
  void FindFollowers(const Subproblem<G>& problem);
  double Try(double part, const Subproblem<G>& problem);

  BlockSystem<G> system_;
  int num_slots_ = 0;              // poses of the system
  std::vector<int> slot_of_name_;  // -1: none
  const std::vector<Index>* names_ = nullptr;
  // Workspace of a step.
  struct Follower {
    int pose, leader;
    G T_leader_pose;
  };
  std::vector<int> slots_;           // by free pose of the problem
  std::vector<Follower> followers_;  // leaders first
  std::vector<double> solution_;     // by slot
  std::vector<double> step_;         // by free pose
  std::vector<G> trial_;
};

extern template class SimplifiedNewton<ceres_costs::SE2>;
extern template class SimplifiedNewton<ceres_costs::SE3>;
extern template class SimplifiedNewton<ceres_costs::YawPose>;

}  // namespace hpgo
