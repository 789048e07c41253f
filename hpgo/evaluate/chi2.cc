#include "hpgo/evaluate/chi2.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ceres/loss_function.h"
#include "hpgo/graph/edge_classes.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;

double Robust(const ceres::LossFunction& loss, double s) {
  double rho[3];
  loss.Evaluate(s, rho);
  return rho[0];
}

}  // namespace

template <typename G>
double EdgeChi2(const PoseGraph<G>& graph, const GraphEdge<G>& edge, ErrorConvention convention) {
  const G T_i_j = graph.nodes()[edge.i].pose.Between(graph.nodes()[edge.j].pose);
  const typename G::Tangent e =
      ceres_costs::DeviationError(convention, edge.measurement.Between(T_i_j));
  return e.dot(edge.information * e);
}

template <typename G>
double PriorChi2(const PoseGraph<G>& graph, const GraphPrior<G>& prior,
                 ErrorConvention convention) {
  const G T_world_sensor = graph.nodes()[prior.node].pose * prior.offset;
  const typename G::Tangent e =
      ceres_costs::DeviationError(convention, prior.measurement.Between(T_world_sensor));
  return e.dot(prior.information * e);
}

template <typename G>
Chi2Report EvaluateChi2(const PoseGraph<G>& graph, const Chi2Options& options) {
  Chi2Report report;
  std::vector<bool> robust;
  if (options.loss != nullptr) {
    robust = options.loss_on_closures_only ? LoopClosures(graph)
                                           : std::vector<bool>(graph.edges().size(), true);
  }
  report.edges.reserve(graph.edges().size());
  for (const GraphEdge<G>& edge : graph.edges()) {
    const double chi2 = EdgeChi2(graph, edge, options.convention);
    const bool with_loss = !robust.empty() && robust[report.edges.size()];
    report.robust_total += with_loss ? Robust(*options.loss, chi2) : chi2;
    report.edge_total += chi2;
    report.edges.push_back(chi2);
  }
  report.priors.reserve(graph.priors().size());
  for (const GraphPrior<G>& prior : graph.priors()) {
    report.priors.push_back(PriorChi2(graph, prior, options.convention));
    report.prior_total += report.priors.back();
  }
  report.total = report.edge_total + report.prior_total;
  report.robust_total =
      options.loss == nullptr ? report.total : report.robust_total + report.prior_total;
  return report;
}

std::vector<WorstEdge> WorstEdges(const std::vector<double>& edge_chi2, int count) {
  std::vector<int> order(edge_chi2.size());
  std::iota(order.begin(), order.end(), 0);
  const std::size_t kept = std::min(order.size(), static_cast<std::size_t>(std::max(count, 0)));
  const auto worse = [&](int a, int b) {
    const bool nan_a = std::isnan(edge_chi2[a]), nan_b = std::isnan(edge_chi2[b]);
    if (nan_a != nan_b) return nan_a;
    if (nan_a || edge_chi2[a] == edge_chi2[b]) return a < b;
    return edge_chi2[a] > edge_chi2[b];
  };
  std::partial_sort(order.begin(), order.begin() + kept, order.end(), worse);
  std::vector<WorstEdge> worst;
  worst.reserve(kept);
  for (std::size_t k = 0; k < kept; ++k) worst.push_back({order[k], edge_chi2[order[k]]});
  return worst;
}

template double EdgeChi2(const PoseGraph<SE2>&, const GraphEdge<SE2>&, ErrorConvention);
template double EdgeChi2(const PoseGraph<SE3>&, const GraphEdge<SE3>&, ErrorConvention);
template double EdgeChi2(const PoseGraph<YawPose>&, const GraphEdge<YawPose>&, ErrorConvention);
template double PriorChi2(const PoseGraph<SE2>&, const GraphPrior<SE2>&, ErrorConvention);
template double PriorChi2(const PoseGraph<SE3>&, const GraphPrior<SE3>&, ErrorConvention);
template double PriorChi2(const PoseGraph<YawPose>&, const GraphPrior<YawPose>&, ErrorConvention);
template Chi2Report EvaluateChi2(const PoseGraph<SE2>&, const Chi2Options&);
template Chi2Report EvaluateChi2(const PoseGraph<SE3>&, const Chi2Options&);
template Chi2Report EvaluateChi2(const PoseGraph<YawPose>&, const Chi2Options&);

}  // namespace hpgo
