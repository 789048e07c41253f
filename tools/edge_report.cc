#include "tools/edge_report.h"

#include <cstdio>
#include <string>

#include "hpgo/evaluate/chi2.h"
#include "hpgo/graph/edge_classes.h"
#include "tools/console.h"

namespace hpgo_cli {

template <typename G>
std::vector<ReportedEdge> FindWorstEdges(const hpgo::PoseGraph<G>& graph,
                                         ceres_costs::ErrorConvention convention, int count) {
  constexpr double kDegrees = 180 / 3.14159265358979323846;
  hpgo::Chi2Options options;
  options.convention = convention;
  const std::vector<double> chi2 = hpgo::EvaluateChi2(graph, options).edges;
  const std::vector<bool> closures = hpgo::LoopClosures(graph);
  std::vector<ReportedEdge> reported;
  for (const hpgo::WorstEdge& worst : hpgo::WorstEdges(chi2, count)) {
    const hpgo::GraphEdge<G>& edge = graph.edges()[worst.edge];
    const hpgo::GraphNode<G>&i = graph.nodes()[edge.i], &j = graph.nodes()[edge.j];
    const typename G::Tangent deviation = DeviationError(
        ceres_costs::ErrorConvention::kSplitLog, edge.measurement.Between(i.pose.Between(j.pose)));
    reported.push_back({i.id, j.id, closures[worst.edge], worst.chi2,
                        deviation.template head<G::kDim>().norm(),
                        deviation.template tail<G::kRotationDof>().norm() * kDegrees});
  }
  return reported;
}

void PrintWorstEdges(const std::vector<ReportedEdge>& edges, double total,
                     void (*print_line)(const std::string&)) {
  char text[160];
  std::snprintf(text, sizeof(text), "%12s %12s  %-8s %14s %8s %10s %10s", "from", "to", "kind",
                "chi2", "share", "metres", "degrees");
  print_line(text);
  for (const ReportedEdge& edge : edges) {
    std::snprintf(text, sizeof(text), "%12lld %12lld  %-8s %14s %6.2f %% %10.4g %10.4g",
                  static_cast<long long>(edge.from), static_cast<long long>(edge.to),
                  edge.is_closure ? "closure" : "odometry", FormatNumber(edge.chi2).c_str(),
                  total > 0 ? 100 * edge.chi2 / total : 0, edge.translation_m, edge.rotation_deg);
    print_line(text);
  }
}

nlohmann::ordered_json WorstEdgesJson(const std::vector<ReportedEdge>& edges) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const ReportedEdge& edge : edges) {
    json.push_back({{"from", edge.from},
                    {"to", edge.to},
                    {"closure", edge.is_closure},
                    {"chi2", edge.chi2},
                    {"translation_m", edge.translation_m},
                    {"rotation_deg", edge.rotation_deg}});
  }
  return json;
}

template std::vector<ReportedEdge> FindWorstEdges(const hpgo::PoseGraph2d&,
                                                  ceres_costs::ErrorConvention, int);
template std::vector<ReportedEdge> FindWorstEdges(const hpgo::PoseGraph<hpgo::YawPose>&,
                                                  ceres_costs::ErrorConvention, int);
template std::vector<ReportedEdge> FindWorstEdges(const hpgo::PoseGraph3d&,
                                                  ceres_costs::ErrorConvention, int);

}  // namespace hpgo_cli
