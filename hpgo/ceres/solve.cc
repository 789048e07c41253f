#include "hpgo/ceres/solve.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>

#include "hpgo/ceres/pose_blocks.h"
#include "hpgo/ceres/pose_system.h"
#include "hpgo/ceres/problem_view.h"
#include "hpgo/ceres/summary.h"
#include "hpgo/ceres/trust_region.h"

namespace hpgo {
namespace {

using Clock = std::chrono::steady_clock;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// Empty if the options ask for nothing but what is done here.
std::string WhyNot(const ceres::Solver::Options& options) {
  std::string error;
  if (!options.IsValid(&error)) return "the options are not valid";
  if (options.minimizer_type != ceres::TRUST_REGION) return "the options ask for a line search";
  if (options.use_inner_iterations) return "the options ask for inner iterations";
  if (options.check_gradients) return "the options ask for gradient checks";
  if (!options.trust_region_minimizer_iterations_to_dump.empty())
    return "the options ask for dumps";
  return "";
}

std::string WhyNot(const ProblemView& problem) {
  for (std::size_t b = 0; b < problem.blocks().size(); ++b) {
    const BlockView& block = problem.blocks()[b];
    if (!block.used) continue;
    for (int k = 0; k < block.size; ++k) {
      if (!std::isfinite(block.values[k])) {
        return problem.NameOf(static_cast<int>(b)) + " is not finite";
      }
    }
  }
  return "";
}

// Empty if the problem was solved.
std::string TrySolve(const ceres::Solver::Options& options, const ceres::Problem& problem,
                     const PoseLayout& layout, ceres::Solver::Summary* summary) {
  std::string reason = WhyNot(options);
  if (!reason.empty()) return reason;
  const Clock::time_point begin = Clock::now();
  const ProblemView view(problem);
  reason = WhyNot(view);
  PoseBlocks poses;
  if (!reason.empty() || !FindPoseBlocks(view, layout.sizes, &poses, &reason)) return reason;
  const std::unique_ptr<PoseSystem> system = MakePoseSystem(view, poses);
  *summary = ceres::Solver::Summary();
  DescribeProblem(options, view, *system, summary);
  summary->preprocessor_time_in_seconds = SecondsSince(begin);
  if (!MinimizeAsCeres(options, system.get(), summary)) {
    return "the costs cannot be evaluated at the start";
  }
  summary->message = "hpgo: " + std::to_string(system->num_free_poses()) + " poses (" +
                     LayoutName(poses.sizes) + "): " + summary->message;
  summary->postprocessor_time_in_seconds = 0;
  summary->total_time_in_seconds = SecondsSince(begin);
  return "";
}

}  // namespace

void Solve(const ceres::Solver::Options& options, ceres::Problem* problem,
           ceres::Solver::Summary* summary, const PoseLayout& layout) {
  const std::string reason = TrySolve(options, *problem, layout, summary);
  if (reason.empty()) return;
  ceres::Solve(options, problem, summary);
  summary->message = "hpgo: left to ceres::Solve: " + reason + ". " + summary->message;
}

void Solve(const ceres::Solver::Options& options, ceres::Problem* problem,
           ceres::Solver::Summary* summary) {
  Solve(options, problem, summary, PoseLayout());
}

}  // namespace hpgo
