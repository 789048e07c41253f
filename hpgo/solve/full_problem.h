// A whole pose graph as one Subproblem.
#pragma once

#include <memory>
#include <vector>

#include "ceres/loss_function.h"
#include "ceres_costs/relative_pose_error.h"
#include "hpgo/graph/pose_graph.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// Holds the terms that the factors of its Subproblem point to. Not synchronized.
template <typename G>
class FullProblem {
 public:
  // `held` are the nodes that do not move, `robust` the edges whose loss is `loss` (not owned, may
  // be null). The graph must pass CheckGraph; it is copied.
  FullProblem(const PoseGraph<G>& graph, const std::vector<int>& held,
              const std::vector<bool>& robust, const ceres::LossFunction* loss,
              ceres_costs::ErrorConvention convention);
  FullProblem(const FullProblem&) = delete;
  FullProblem& operator=(const FullProblem&) = delete;

  // Poses by node index; quaternions are normalized on the way in.
  void SetPoses(const std::vector<G>& poses);
  const G& pose(int node) const { return subproblem_.poses[slots_[node]]; }
  bool is_free(int node) const { return slots_[node] < subproblem_.num_free; }
  int slot(int node) const { return slots_[node]; }  // among the subproblem's poses

  // Another loss for the edges that have one.
  void SetLoss(const ceres::LossFunction* loss);

  // The objective, and chi2 = sum of e' Omega e without the loss, at the poses set.
  double Cost() const { return Sum(true); }
  double Chi2() const { return Sum(false); }

  Subproblem<G>* subproblem() { return &subproblem_; }

 private:
  double Sum(bool with_loss) const;

  std::vector<ceres_costs::RelativePoseTerm<G>> terms_;
  std::vector<G> offsets_;
  std::vector<bool> robust_;  // by edge
  std::vector<int> slots_;    // node index -> index into the subproblem's poses
  Subproblem<G> subproblem_;
};

}  // namespace hpgo
