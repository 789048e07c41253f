// A graph brought to an optimizer node by node without an update, and its optimum.
#pragma once

#include "gtest/gtest.h"
#include "hpgo/optimizer.h"
#include "hpgo/replay.h"
#include "hpgo/solve/full_solve.h"

namespace hpgo {

template <typename G>
void BringAll(const PoseGraph<G>& graph, Optimizer<G>* optimizer) {
  for (const ReplayStep& step : ReplaySteps(graph)) {
    ASSERT_TRUE(ApplyStep<G>(graph, step, nullptr, optimizer).ok());
  }
}

template <typename G>
double OptimumOf(PoseGraph<G> graph, InitMethod init = InitMethod::kAuto) {
  FullSolveOptions options;
  options.init = init;
  const FullSolveReport report = SolveFull(options, &graph);
  EXPECT_TRUE(report.converged);
  return report.cost_after;
}

}  // namespace hpgo
