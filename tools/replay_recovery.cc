#include "tools/replay_recovery.h"

#include <algorithm>
#include <cmath>

namespace hpgo_cli {

using hpgo::SE2;
using hpgo::SE3;
using hpgo::YawPose;

template <typename G>
hpgo::Result<Recovery> RecoverFromFarClosure(const hpgo::PoseGraph<G>& graph, double factor,
                                             const hpgo::UpdateLimits& limits,
                                             const LossChoice& loss,
                                             hpgo::Optimizer<G>* optimizer) {
  constexpr int kReported[] = {1, 2, 5, 10, 20, 50, 100};
  const auto& nodes = graph.nodes();
  const hpgo::NodeId i = nodes[nodes.size() / kMinFarClosureNodes].id, j = nodes.back().id;
  const auto X_i = optimizer->GetPose(i), X_j = optimizer->GetPose(j);
  if (!X_i.ok()) return X_i.status();
  if (!X_j.ok()) return X_j.status();

  const typename G::Matrix information = graph.edges().front().information;
  const double mean =
      std::max(optimizer->Cost() / static_cast<double>(optimizer->num_edges()), 1e-6);
  typename G::Tangent offset = G::Tangent::Zero();
  offset(0) = std::sqrt(factor * mean / information(0, 0));
  Recovery recovery;
  recovery.edge = std::to_string(i) + " -> " + std::to_string(j);
  recovery.offset_m = offset(0);
  const auto edge = optimizer->AddEdge(i, j, X_i->Between(*X_j).Retract(offset), information,
                                       MakeSharedLoss(loss));
  if (!edge.ok()) return edge.status();
  const auto error = optimizer->GetEdgeError(*edge);
  if (error.ok()) recovery.edge_chi2 = error->chi2;

  const hpgo::Result<FullComparison> comparison = CompareWithFull(*optimizer, loss);
  if (!comparison.ok()) return comparison.status();
  recovery.optimum = comparison->optimum;
  int updates = 0;
  const auto cancelled = [&] { return limits.cancel != nullptr && *limits.cancel; };
  for (const int reported : kReported) {
    while (updates < reported && !recovery.at_rest && !cancelled()) {
      const hpgo::UpdateReport report = optimizer->Update(limits);
      if (!report.status.ok()) return report.status;
      ++updates;
      recovery.slowest_ms = std::max(recovery.slowest_ms, 1e3 * report.seconds);
      recovery.at_rest = report.at_rest;
    }
    const auto num_edges = static_cast<std::int64_t>(optimizer->num_edges());
    recovery.points.push_back(
        {updates, GapPercent(optimizer->Cost(), recovery.optimum, num_edges)});
    if (recovery.at_rest || cancelled()) break;
  }
  return recovery;
}

template hpgo::Result<Recovery> RecoverFromFarClosure(const hpgo::PoseGraph<SE2>&, double,
                                                      const hpgo::UpdateLimits&, const LossChoice&,
                                                      hpgo::Optimizer<SE2>*);
template hpgo::Result<Recovery> RecoverFromFarClosure(const hpgo::PoseGraph<SE3>&, double,
                                                      const hpgo::UpdateLimits&, const LossChoice&,
                                                      hpgo::Optimizer<SE3>*);
template hpgo::Result<Recovery> RecoverFromFarClosure(const hpgo::PoseGraph<YawPose>&, double,
                                                      const hpgo::UpdateLimits&, const LossChoice&,
                                                      hpgo::Optimizer<YawPose>*);

}  // namespace hpgo_cli
