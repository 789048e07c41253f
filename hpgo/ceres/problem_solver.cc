#include "hpgo/ceres/problem_solver.h"

#include <cmath>
#include <unordered_set>
#include <utility>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"
#include "hpgo/ceres/kept_problem.h"
#include "hpgo/ceres/level_problem.h"
#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/problem_view.h"
#include "hpgo/ceres/recognize_layout.h"
#include "hpgo/ceres/solve.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

class ProblemSolver::Impl {
 public:
  Impl(ceres::Problem* problem, const ProblemSolverOptions& options)
      : problem_(*problem), options_(options) {}

  UpdateReport Run(const UpdateLimits& limits, bool refine) {
    TakeIn();
    if (kept_ == nullptr) return SolveWhole(limits);
    return refine ? kept_->Refine(limits) : kept_->Update(limits);
  }

  void NoteAdded(ceres::ResidualBlockId id) {
    if (kept_ == nullptr || options_.watch) return;
    added_.push_back(id);
    waiting_.insert(id);
  }
  void NoteRemoved(ceres::ResidualBlockId id) {
    if (waiting_.erase(id) == 0 && kept_ != nullptr) Note(kept_->Remove(id));
  }
  void NoteChanged(const double* block) {
    if (kept_ != nullptr && !options_.watch) changed_.push_back(block);
  }

  // Takes a call's outcome: what cannot be kept is given up.
  void Note(const Status& status) {
    if (status.ok()) return;
    kept_.reset();
    why_not_kept_ = status.message();
  }

  ceres::Problem& problem() { return problem_; }
  KeptProblem* kept() { return kept_.get(); }
  const std::string& why_not_kept() const { return why_not_kept_; }

 private:
  void TakeIn() {
    if (kept_ == nullptr) {
      Begin();
    } else if (options_.watch) {
      Note(kept_->LookAtAll());
      // What is new may be recognizable where what was there is gone.
      if (kept_ == nullptr) Begin();
    } else {
      TakeInQueued();
    }
    added_.clear();
    waiting_.clear();
    changed_.clear();
    ChooseConvention();
  }

  // Waits until now: a pose's manifolds are often set, and its blocks held, one by one after its
  // first residual.
  void TakeInQueued() {
    for (std::size_t k = 0; k < changed_.size() && kept_ != nullptr; ++k) {
      Note(kept_->Look(changed_[k]));
    }
    for (std::size_t k = 0; k < added_.size() && kept_ != nullptr; ++k) {
      if (waiting_.erase(added_[k]) > 0) Note(kept_->Add(added_[k]));
    }
  }

  void Begin() {
    if (problem_.NumResidualBlocks() == 0) {
      why_not_kept_ = "there is no residual";
      return;
    }
    const ProblemView view(problem_);
    PoseBlocks poses;
    PoseLayout layout;
    if (!FindPoseBlocks(view, options_.layout.sizes, &poses, &why_not_kept_) ||
        !RecognizeLayout(view, poses, options_.layout, &layout, &why_not_kept_)) {
      return;
    }
    why_not_kept_.clear();
    has_convention_ = false;
    Keep(options_.optimizer, layout);
  }

  // Once enough costs have been seen to tell theirs.
  void ChooseConvention() {
    if (kept_ == nullptr || has_convention_ || !kept_->HasSampled()) return;
    has_convention_ = true;
    OptimizerOptions options = options_.optimizer;
    options.convention = kept_->BestConvention();
    if (options.convention != options_.optimizer.convention) {
      Keep(options, PoseLayout(kept_->layout()));
    }
  }

  void Keep(const OptimizerOptions& options, const PoseLayout& layout) {
    if (layout.kind == PoseLayout::Kind::kXYTheta) {
      kept_ = std::make_unique<KeptProblemOf<SE2>>(&problem_, options, layout);
    } else if (layout.kind == PoseLayout::Kind::kXYZYaw) {
      kept_ = std::make_unique<KeptProblemOf<YawPose>>(&problem_, options, layout);
    } else {
      kept_ = std::make_unique<KeptProblemOf<SE3>>(&problem_, options, layout);
    }
    Note(kept_->LookAtAll());
  }

  UpdateReport SolveWhole(const UpdateLimits& limits) {
    UpdateReport report;
    if (problem_.NumResidualBlocks() == 0) {
      report.at_rest = true;
      return report;
    }
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    options.logging_type = ceres::SILENT;
    if (limits.max_seconds > 0) options.max_solver_time_in_seconds = limits.max_seconds;
    ceres::Solver::Summary summary;
    hpgo::Solve(options, &problem_, &summary, options_.layout);
    report.seconds = summary.total_time_in_seconds;
    report.cost_decrease = 2 * (summary.initial_cost - summary.final_cost);
    report.at_rest = summary.termination_type == ceres::CONVERGENCE;
    if (!summary.IsSolutionUsable()) {
      report.status = Status(StatusCode::kNoSolution, summary.message);
    }
    return report;
  }

  ceres::Problem& problem_;
  const ProblemSolverOptions options_;
  std::unique_ptr<KeptProblem> kept_;
  bool has_convention_ = false;  // of what is kept: once chosen it stays
  std::string why_not_kept_ = "not looked at yet";
  // Changes through the calls that no update has taken in.
  std::vector<ceres::ResidualBlockId> added_;
  std::unordered_set<ceres::ResidualBlockId> waiting_;  // those of them that are still there
  std::vector<const double*> changed_;
};

ProblemSolver::ProblemSolver(ceres::Problem* problem, const ProblemSolverOptions& options)
    : impl_(std::make_unique<Impl>(problem, options)) {}
ProblemSolver::~ProblemSolver() = default;

UpdateReport ProblemSolver::Update(const UpdateLimits& limits) { return impl_->Run(limits, false); }
UpdateReport ProblemSolver::Refine(const UpdateLimits& limits) { return impl_->Run(limits, true); }

ceres::ResidualBlockId ProblemSolver::AddResidualBlock(ceres::CostFunction* cost,
                                                       ceres::LossFunction* loss,
                                                       const std::vector<double*>& blocks) {
  const ceres::ResidualBlockId id = impl_->problem().AddResidualBlock(cost, loss, blocks);
  impl_->NoteAdded(id);
  return id;
}

void ProblemSolver::RemoveResidualBlock(ceres::ResidualBlockId id) {
  impl_->NoteRemoved(id);
  impl_->problem().RemoveResidualBlock(id);
}

void ProblemSolver::RemoveParameterBlock(double* block) {
  std::vector<ceres::ResidualBlockId> ids;
  impl_->problem().GetResidualBlocksForParameterBlock(block, &ids);
  for (const ceres::ResidualBlockId id : ids) RemoveResidualBlock(id);
  impl_->problem().RemoveParameterBlock(block);
}

void ProblemSolver::SetParameterBlockConstant(double* block) {
  impl_->problem().SetParameterBlockConstant(block);
  NoteChanged(block);
}

void ProblemSolver::SetParameterBlockVariable(double* block) {
  impl_->problem().SetParameterBlockVariable(block);
  NoteChanged(block);
}

void ProblemSolver::NoteChanged(double* block) { impl_->NoteChanged(block); }

const std::string& ProblemSolver::why_not_kept() const { return impl_->why_not_kept(); }
const PoseLayout* ProblemSolver::layout() const {
  return impl_->kept() == nullptr ? nullptr : &impl_->kept()->layout();
}
double ProblemSolver::Cost() const {
  return impl_->kept() == nullptr ? std::nan("") : impl_->kept()->Cost() / 2;
}

template <typename G>
Result<std::shared_ptr<CeresLevel<G>>> ProblemSolver::LevelProblem(int level) {
  auto* kept = dynamic_cast<KeptProblemOf<G>*>(impl_->kept());
  if (kept == nullptr) {
    return Status(StatusCode::kInvalidArgument, impl_->kept() == nullptr
                                                    ? "nothing is kept: " + why_not_kept()
                                                    : "the problem's poses are of another group");
  }
  return kept->optimizer().LevelProblem(level);
}
template Result<std::shared_ptr<CeresLevel<SE2>>> ProblemSolver::LevelProblem(int);
template Result<std::shared_ptr<CeresLevel<SE3>>> ProblemSolver::LevelProblem(int);
template Result<std::shared_ptr<CeresLevel<YawPose>>> ProblemSolver::LevelProblem(int);

Result<std::int64_t> ProblemSolver::GroupOf(const double* block, int level) const {
  if (impl_->kept() != nullptr) return impl_->kept()->GroupOf(block, level);
  return Status(StatusCode::kInvalidArgument, "nothing is kept: " + why_not_kept());
}

}  // namespace hpgo
