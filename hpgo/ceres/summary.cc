#include "hpgo/ceres/summary.h"

namespace hpgo {

void DescribeProblem(const ceres::Solver::Options& options, const ProblemView& problem,
                     const PoseSystem& system, ceres::Solver::Summary* summary) {
  summary->minimizer_type = ceres::TRUST_REGION;
  summary->trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
  summary->num_parameter_blocks = static_cast<int>(problem.blocks().size());
  summary->num_parameters = problem.num_values();
  summary->num_effective_parameters = 0;
  for (const BlockView& block : problem.blocks()) {
    summary->num_effective_parameters += block.tangent;
  }
  summary->num_residual_blocks = static_cast<int>(problem.residuals().size());
  summary->num_residuals = problem.num_residuals();
  summary->num_parameter_blocks_reduced = system.num_active_blocks();
  summary->num_parameters_reduced = system.num_active_parameters();
  summary->num_effective_parameters_reduced = system.num_active_dof();
  summary->num_residual_blocks_reduced = system.num_active_residual_blocks();
  summary->num_residuals_reduced = system.num_active_residuals();
  summary->is_constrained = false;
  summary->num_threads_given = options.num_threads;
  summary->num_threads_used = 1;
  summary->linear_solver_type_given = options.linear_solver_type;
  summary->linear_solver_type_used = ceres::SPARSE_NORMAL_CHOLESKY;
  summary->linear_solver_ordering_given = {};
  summary->linear_solver_ordering_used = {system.num_active_blocks()};
  summary->preconditioner_type_given = options.preconditioner_type;
  summary->preconditioner_type_used = options.preconditioner_type;
  summary->visibility_clustering_type = options.visibility_clustering_type;
  summary->dense_linear_algebra_library_type = options.dense_linear_algebra_library_type;
  summary->sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  summary->inner_iterations_given = summary->inner_iterations_used = false;
  summary->num_inner_iteration_steps = summary->num_line_search_steps = 0;
  summary->inner_iteration_time_in_seconds = 0;
  summary->line_search_cost_evaluation_time_in_seconds = 0;
  summary->line_search_gradient_evaluation_time_in_seconds = 0;
  summary->line_search_polynomial_minimization_time_in_seconds = 0;
  summary->line_search_total_time_in_seconds = 0;
}

}  // namespace hpgo
