// A ceres::Problem of poses that grows and shrinks, kept near its optimum by bounded updates.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ceres/problem.h"
#include "hpgo/ceres/pose_layout.h"
#include "hpgo/graph/status.h"
#include "hpgo/optimizer_options.h"

namespace hpgo {

template <typename G>
class CeresLevel;

struct ProblemSolverOptions {
  OptimizerOptions optimizer;
  // What is known of how poses are stored; the rest is found out.
  PoseLayout layout;
  // Whether Update looks at the whole problem for what was added, removed, held, freed or moved
  // without a word: O(N), some microseconds a residual. False: all changes go through the calls
  // below, and Update costs what they cost; a cost must then not change its values in place.
  bool watch = true;
};

// Keeps a hierarchy over the poses of a problem.
//
//   hpgo::ProblemSolver solver(&problem);
//   // At every keyframe: problem.AddResidualBlock(...) as ever, then instead of ceres::Solve
//   solver.Update();
//
// Each Update takes in what has changed and makes one bounded step of hpgo::Optimizer; blocks that
// moved are written back. Residuals over two poses must be functions of their relative pose;
// residuals over one pose, or over one and constant blocks, are priors. The problem must outlive
// this, and costs, losses and manifolds be in it for as long as they are used, as Ceres demands.
//
// A problem that cannot be kept, because something in it is more than a pose graph or is stored in
// no recognized way, is solved whole by hpgo::Solve at each Update, and `why_not_kept` says why;
// once that is gone it is kept again. Not synchronized, and not to be used while a solve of the
// same problem runs elsewhere.
class ProblemSolver {
 public:
  explicit ProblemSolver(ceres::Problem* problem, const ProblemSolverOptions& options = {});
  ~ProblemSolver();
  ProblemSolver(const ProblemSolver&) = delete;
  ProblemSolver& operator=(const ProblemSolver&) = delete;

  // One bounded step; idle work until nothing is stressed. The status is that of Optimizer, or
  // kNoSolution where hpgo::Solve, called instead, found nothing usable.
  UpdateReport Update(const UpdateLimits& limits = {});
  UpdateReport Refine(const UpdateLimits& limits = {});

  // As those of the problem, which they call. O(1) beside what the problem's own cost.
  ceres::ResidualBlockId AddResidualBlock(ceres::CostFunction* cost, ceres::LossFunction* loss,
                                          const std::vector<double*>& blocks);
  template <typename... Blocks>
  ceres::ResidualBlockId AddResidualBlock(ceres::CostFunction* cost, ceres::LossFunction* loss,
                                          double* first, Blocks*... others) {
    return AddResidualBlock(cost, loss, std::vector<double*>{first, others...});
  }
  void RemoveResidualBlock(ceres::ResidualBlockId id);
  // With all residuals over it.
  void RemoveParameterBlock(double* block);
  void SetParameterBlockConstant(double* block);
  void SetParameterBlockVariable(double* block);
  // The caller has written other values into a block, or is to be believed that it has not: needed
  // only without `watch`.
  void NoteChanged(double* block);

  // Empty while the hierarchy is kept; known after the first Update.
  const std::string& why_not_kept() const;
  // How poses are stored, as recognized. Null while nothing is kept.
  const PoseLayout* layout() const;
  // The sum of the losses, as Ceres has it: sum rho(|r|^2) / 2, over residuals that are not all
  // held. NaN while nothing is kept. O(N).
  double Cost() const;

  // A level of the hierarchy as a ceres::Problem (hpgo/ceres/level_problem.h), and the node of a
  // level that a block of the problem moves with: CeresLevel::BlockOf of it is that node's block.
  // G is ceres_costs::SE2, SE3 or YawPose. kInvalidArgument for the others of these, where there is
  // no such level, or nothing is kept; kNotFound for a block of no pose.
  template <typename G>
  Result<std::shared_ptr<CeresLevel<G>>> LevelProblem(int level);
  Result<std::int64_t> GroupOf(const double* block, int level) const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hpgo
