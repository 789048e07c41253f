// The inside of SolveFull; see full_solve.h.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <vector>

#include "hpgo/solve/full_problem.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// Use an object once.
template <typename G>
class FullSolve {
 public:
  // Both must outlive this.
  FullSolve(const FullSolveOptions& options, PoseGraph<G>* graph)
      : options_(options), graph_(*graph) {}

  FullSolveReport Run();

 private:
  using Clock = std::chrono::steady_clock;
  static double SecondsSince(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
  }

  // full_solve.cc
  Status MakeProblem();
  Status Start();
  Status Optimize();
  std::size_t NumFactors() const { return problem_->subproblem()->factors.size(); }
  int Iterations(double work, int at_least) const;
  std::vector<G> Poses() const;
  bool Lower(double cost, double than) const;
  bool Same(double a, double b) const { return !Lower(a, b) && !Lower(b, a); }
  SubproblemSummary Minimize(int max_iterations, bool graduated);
  Status RunToEnd(const std::vector<G>& start, int max_iterations, InitCandidate* candidate);
  void NoteUndetermined();
  void Take();

  // full_solve_search.cc
  bool IsSuspicious() const;
  int Agreeing() const;
  Status SearchFurther();
  double StartCost() const;
  std::vector<double> Trust() const;

  const FullSolveOptions& options_;
  PoseGraph<G>& graph_;
  const Clock::time_point begin_ = Clock::now();
  FullSolveReport report_;
  std::vector<std::unique_ptr<ceres::LossFunction>> losses_;  // graduated; the last is what counts
  std::unique_ptr<SubproblemSolver<G>> solver_;
  std::unique_ptr<FullProblem<G>> problem_;
  std::vector<G> start_, best_;  // by node; best_ is empty before the first run has ended
};

extern template class FullSolve<SE2>;
extern template class FullSolve<SE3>;
extern template class FullSolve<YawPose>;

}  // namespace hpgo
