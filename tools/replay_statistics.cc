#include "tools/replay_statistics.h"

#include <algorithm>
#include <cmath>

namespace hpgo_cli {
namespace {

UpdateBreakdown BreakdownOf(const UpdateSample& sample) {
  UpdateBreakdown parts;
  parts.insert = sample.insert_ms;
  parts.merge = sample.merge_ms;
  parts.examine = sample.examine_ms;
  parts.top = sample.top_ms;
  parts.windows = sample.windows_ms;
  parts.other =
      sample.wall_ms - parts.insert - parts.merge - parts.examine - parts.top - parts.windows;
  return parts;
}

template <typename Predicate>
UpdateGroup MakeGroup(const char* name, const std::vector<UpdateSample>& samples,
                      Predicate&& belongs) {
  std::vector<float> wall, cpu;
  for (const UpdateSample& sample : samples) {
    if (!belongs(sample)) continue;
    wall.push_back(sample.wall_ms);
    cpu.push_back(sample.cpu_ms);
  }
  UpdateGroup group;
  group.name = name;
  group.count = static_cast<std::int64_t>(wall.size());
  group.wall = SummarizeLatency(std::move(wall));
  group.cpu = SummarizeLatency(std::move(cpu));
  return group;
}

// Of at least one value, ascending.
template <typename T>
double Percentile(const std::vector<T>& sorted, double share) {
  // Against 0.95 * 100 = 95.00000000000001.
  const double rank = std::ceil(share * static_cast<double>(sorted.size()) * (1 - 1e-12));
  return sorted[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

}  // namespace

const std::vector<std::pair<const char*, double UpdateBreakdown::*>>& BreakdownParts() {
  static const auto* parts = new std::vector<std::pair<const char*, double UpdateBreakdown::*>>{
      {"insert", &UpdateBreakdown::insert},   {"merge", &UpdateBreakdown::merge},
      {"examine", &UpdateBreakdown::examine}, {"top", &UpdateBreakdown::top},
      {"windows", &UpdateBreakdown::windows}, {"other", &UpdateBreakdown::other}};
  return *parts;
}

const std::vector<std::pair<const char*, double LatencyFigures::*>>& LatencyQuantiles() {
  static const auto* quantiles = new std::vector<std::pair<const char*, double LatencyFigures::*>>{
      {"p50", &LatencyFigures::p50},
      {"p95", &LatencyFigures::p95},
      {"p99", &LatencyFigures::p99},
      {"max", &LatencyFigures::max}};
  return *quantiles;
}

const std::vector<std::pair<const char*, double Distribution::*>>& DistributionFigures() {
  static const auto* figures = new std::vector<std::pair<const char*, double Distribution::*>>{
      {"mean", &Distribution::mean},
      {"median", &Distribution::median},
      {"p90", &Distribution::p90},
      {"max", &Distribution::max}};
  return *figures;
}

Distribution Summarize(std::vector<double> values) {
  Distribution distribution;
  if (values.empty()) return distribution;
  std::sort(values.begin(), values.end());
  for (const double value : values) {
    distribution.mean += value / static_cast<double>(values.size());
  }
  distribution.median = Percentile(values, 0.5);
  distribution.p90 = Percentile(values, 0.9);
  distribution.max = values.back();
  return distribution;
}

LatencyFigures SummarizeLatency(std::vector<float> milliseconds) {
  LatencyFigures figures;
  if (milliseconds.empty()) return figures;
  std::sort(milliseconds.begin(), milliseconds.end());
  const double count = static_cast<double>(milliseconds.size());
  for (const float value : milliseconds) figures.mean += value / count;
  figures.p50 = Percentile(milliseconds, 0.5);
  figures.p95 = Percentile(milliseconds, 0.95);
  figures.p99 = Percentile(milliseconds, 0.99);
  figures.max = milliseconds.back();
  return figures;
}

ReplayStatistics SummarizeUpdates(const std::vector<UpdateSample>& samples) {
  ReplayStatistics statistics;
  statistics.groups = {
      MakeGroup("all", samples, [](const UpdateSample&) { return true; }),
      MakeGroup("closures", samples, [](const UpdateSample& s) { return s.closes_loop; }),
      MakeGroup("odometry", samples, [](const UpdateSample& s) { return !s.closes_loop; })};
  if (samples.empty()) return statistics;
  const double share = 1.0 / static_cast<double>(samples.size());
  for (const UpdateSample& sample : samples) {
    const UpdateBreakdown parts = BreakdownOf(sample);
    for (const auto& [name, part] : BreakdownParts()) {
      statistics.mean.*part += share * parts.*part;
    }
  }
  const auto worst = std::max_element(
      samples.begin(), samples.end(),
      [](const UpdateSample& a, const UpdateSample& b) { return a.wall_ms < b.wall_ms; });
  statistics.worst_update = worst->update;
  statistics.worst = BreakdownOf(*worst);
  return statistics;
}

}  // namespace hpgo_cli
