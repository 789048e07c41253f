#include "tools/replay_closures.h"

#include <algorithm>

#include "hpgo/report/line_chart.h"

namespace hpgo_cli {
namespace {

using hpgo::SE2;
using hpgo::SE3;
using hpgo::YawPose;

template <typename Value>
Distribution SummarizeComparisons(const std::vector<FullComparison>& comparisons, Value value) {
  std::vector<double> values;
  values.reserve(comparisons.size());
  for (const FullComparison& comparison : comparisons) values.push_back(comparison.*value);
  return Summarize(std::move(values));
}

}  // namespace

Distribution ClosureFigures::gap_percent() const {
  return SummarizeComparisons(comparisons, &FullComparison::gap_percent);
}

Distribution ClosureFigures::ate_m() const {
  return SummarizeComparisons(comparisons, &FullComparison::ate_m);
}

std::vector<std::int64_t> SampleEvenly(std::int64_t total, std::int64_t count) {
  count = std::min(count, total);
  std::vector<std::int64_t> sample;
  for (std::int64_t k = 0; k < count; ++k) {
    sample.push_back(count == 1 ? total - 1 : k * (total - 1) / (count - 1));
  }
  return sample;
}

template <typename G>
ClosureReference<G>::ClosureReference(const hpgo::PoseGraph<G>& graph, const LossChoice& loss)
    : graph_(graph), loss_(loss), poses_(graph.nodes().size()) {}

template <typename G>
hpgo::Status ClosureReference<G>::Add(const hpgo::ReplayStep& step) {
  const hpgo::Result<G> pose = hpgo::StartPose<G>(
      graph_, step, [this](int node) -> hpgo::Result<G> { return poses_[node]; });
  if (!pose.ok()) return pose.status();
  poses_[step.node] = *pose;
  added_.push_back(step.node);
  return hpgo::Status::Ok();
}

template <typename G>
hpgo::Result<FullComparison> ClosureReference<G>::Compare(const hpgo::Optimizer<G>& optimizer) {
  hpgo::PoseGraph<G> reference = optimizer.ToGraph();
  const auto in_reference = [&](int node) { return *reference.Find(graph_.nodes()[node].id); };
  for (const int node : added_) {
    hpgo::GraphNode<G>& target = reference.node(in_reference(node));
    if (!target.fixed) target.pose = poses_[node];
  }
  hpgo::Result<FullComparison> comparison = CompareWithFull(optimizer, loss_, &reference);
  if (!comparison.ok()) return comparison;
  for (const int node : added_) poses_[node] = reference.nodes()[in_reference(node)].pose;
  return comparison;
}

hpgo::Result<std::string> ClosureChart(const ClosureFigures& figures, const std::string& title) {
  // Below these there is nothing to see, and a logarithmic axis has no zero.
  constexpr double kLeastPercent = 1e-6, kLeastMeters = 1e-8;
  hpgo::ChartSeries gap, ate;
  gap.name = "gap, %";
  ate.name = "ATE to the optimum, m";
  gap.markers = ate.markers = true;
  for (const FullComparison& comparison : figures.comparisons) {
    for (hpgo::ChartSeries* series : {&gap, &ate}) {
      series->x.push_back(static_cast<double>(comparison.nodes));
    }
    gap.y.push_back(std::max(comparison.gap_percent, kLeastPercent));
    ate.y.push_back(std::max(comparison.ate_m, kLeastMeters));
  }
  hpgo::LineChartOptions options;
  options.title = title;
  options.x_label = "nodes";
  options.y_label = "right after the closing update";
  options.log_y = true;
  return hpgo::LineChartSvg({gap, ate}, options);
}

template class ClosureReference<SE2>;
template class ClosureReference<SE3>;
template class ClosureReference<YawPose>;

}  // namespace hpgo_cli
