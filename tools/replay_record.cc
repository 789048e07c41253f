// A replay's figures for scripts.
#include <sys/stat.h>

#include <algorithm>
#include <utility>

#include "hpgo/io/input_text.h"
#include "hpgo/io/output_file.h"
#include "hpgo/solve/solver_factory.h"
#include "tools/replay_report.h"

namespace hpgo_cli {
namespace {

using nlohmann::ordered_json;

ordered_json ComparisonJson(const FullComparison& comparison) {
  return {{"percent", comparison.percent},
          {"nodes", comparison.nodes},
          {"edges", comparison.edges},
          {"cost", comparison.cost},
          {"optimum", comparison.optimum},
          {"optimum_from", comparison.start},
          {"gap_percent", comparison.gap_percent},
          {"ate_m", comparison.ate_m},
          {"ate_rad", comparison.ate_rad},
          {"seconds", comparison.seconds}};
}

ordered_json LatencyJson(const LatencyFigures& latency) {
  ordered_json json = {{"mean", latency.mean}};
  for (const auto& [name, quantile] : LatencyQuantiles()) json[name] = latency.*quantile;
  return json;
}

ordered_json BreakdownJson(const UpdateBreakdown& breakdown) {
  ordered_json json;
  for (const auto& [name, part] : BreakdownParts()) json[name] = breakdown.*part;
  return json;
}

ordered_json RefineJson(const RefineResult& refine) {
  ordered_json json = {{"seconds", refine.report.seconds},       {"windows", refine.report.windows},
                       {"top_solves", refine.report.top_solves}, {"at_rest", refine.report.at_rest},
                       {"cost_before", refine.cost_before},      {"cost_after", refine.cost_after}};
  if (refine.before.has_value()) json["gap_percent_before"] = refine.before->gap_percent;
  if (refine.after.has_value()) {
    json["gap_percent_after"] = refine.after->gap_percent;
    json["ate_m_after"] = refine.after->ate_m;
  }
  return json;
}

ordered_json DistributionJson(const Distribution& distribution) {
  ordered_json json;
  for (const auto& [name, figure] : DistributionFigures()) json[name] = distribution.*figure;
  return json;
}

ordered_json ClosuresJson(const ClosureFigures& closures) {
  ordered_json comparisons = ordered_json::array();
  for (const FullComparison& comparison : closures.comparisons) {
    comparisons.push_back(ComparisonJson(comparison));
  }
  return {{"updates", closures.closing_updates},
          {"compared", closures.comparisons.size()},
          {"gap_percent", DistributionJson(closures.gap_percent())},
          {"ate_m", DistributionJson(closures.ate_m())},
          {"comparisons", comparisons}};
}

ordered_json SettingsJson(const ReplayFigures& figures) {
  const ReplaySettings& settings = figures.settings;
  const hpgo::OptimizerOptions& options = settings.options;
  return {{"preset", figures.names.preset},
          {"engine", hpgo::EngineName(options.engine)},
          {"mode", figures.names.mode},
          {"solve_every", figures.names.solve_every},
          {"stale_poses", settings.stale_poses},
          {"stats_from", settings.stats_from},
          {"window_nodes", options.window_nodes},
          {"window_edges", options.window_edges},
          {"max_top_nodes", options.max_top_nodes},
          {"max_top_edges", options.max_top_edges},
          {"max_windows", options.max_windows},
          {"stress_threshold", options.stress_threshold},
          {"update_seconds", settings.update_seconds},
          {"loss", settings.loss.name},
          {"loss_scale", settings.loss.scale}};
}

// The table's columns with the values of this replay.
std::vector<std::pair<std::string, std::string>> SummaryColumns(const ReplayFigures& figures) {
  std::string input = BaseName(figures.names.input);
  for (char& c : input) {
    if (c == ',' || c == '"' || c == '\n') c = '_';
  }
  std::vector<std::pair<std::string, std::string>> columns = {
      {"input", input},
      {"nodes", std::to_string(figures.nodes)},
      {"edges", std::to_string(figures.edges)},
      {"preset", figures.names.preset},
      {"engine", hpgo::EngineName(figures.settings.options.engine)},
      {"mode", figures.names.mode},
      {"updates", std::to_string(figures.result.updates)}};
  for (const UpdateGroup& group : figures.statistics.groups) {
    columns.emplace_back(group.name, std::to_string(group.count));
    for (const auto& [clock, latency] :
         {std::make_pair("wall", &group.wall), std::make_pair("cpu", &group.cpu)}) {
      const std::string prefix = group.name + "_" + clock + "_";
      columns.emplace_back(prefix + "mean_ms", FormatAs("%.4g", latency->mean));
      for (const auto& [name, quantile] : LatencyQuantiles()) {
        columns.emplace_back(prefix + name + "_ms", FormatAs("%.4g", latency->*quantile));
      }
    }
  }
  for (const auto& [name, part] : BreakdownParts()) {
    columns.emplace_back(std::string(name) + "_ms",
                         FormatAs("%.4g", figures.statistics.mean.*part));
  }
  const std::vector<FullComparison>& comparisons = figures.result.comparisons;
  double worst_gap = 0;
  for (const FullComparison& comparison : comparisons) {
    worst_gap = std::max(worst_gap, comparison.gap_percent);
  }
  columns.emplace_back("worst_gap_percent", comparisons.empty() ? "" : FormatAs("%.3g", worst_gap));
  const ClosureFigures& closures = figures.result.closures;
  const Distribution gap = closures.gap_percent(), ate = closures.ate_m();
  for (const auto& [prefix, distribution] :
       {std::make_pair("closing_gap_percent_", &gap), std::make_pair("closing_ate_m_", &ate)}) {
    for (const auto& [name, figure] : DistributionFigures()) {
      columns.emplace_back(
          std::string(prefix) + name,
          closures.comparisons.empty() ? "" : FormatAs("%.3g", distribution->*figure));
    }
  }
  columns.emplace_back("chi2", FormatAs("%.9g", figures.chi2));
  columns.emplace_back("levels", std::to_string(figures.levels.size()));
  columns.emplace_back("bytes_per_node", FormatAs("%.0f", BytesPerNode(figures)));
  columns.emplace_back(
      "peak_memory_mb",
      FormatAs("%.0f", static_cast<double>(figures.result.peak_memory) / kMegabyte));
  columns.emplace_back("total_seconds", FormatAs("%.4g", figures.result.seconds));
  return columns;
}

// What a table with these columns holds already: the header at least.
hpgo::Result<std::string> OldSummaries(const std::string& header, const std::string& path) {
  struct stat ignored = {};
  if (stat(path.c_str(), &ignored) != 0) return header;
  const hpgo::Result<hpgo::InputText> old = hpgo::InputText::Read(path);
  if (!old.ok()) return old.status();
  if (old->text().empty()) return header;
  if (old->text().substr(0, header.size()) != header) {
    return hpgo::Status(hpgo::StatusCode::kMalformed,
                        path + ":1: has other columns than a summary of hpgo replay");
  }
  return std::string(old->text());
}

// Lines of CSV: the names of the columns, and the values.
std::pair<std::string, std::string> SummaryLines(const ReplayFigures& figures) {
  std::string header, line;
  for (const auto& [name, value] : SummaryColumns(figures)) {
    header += (header.empty() ? "" : ",") + name;
    line += (line.empty() ? "" : ",") + value;
  }
  return {header + "\n", line + "\n"};
}

}  // namespace

ordered_json ReplayJson(const ReplayFigures& figures) {
  const ReplayResult& result = figures.result;
  ordered_json latency;
  for (const UpdateGroup& group : figures.statistics.groups) {
    latency[group.name] = {{"updates", group.count},
                           {"wall", LatencyJson(group.wall)},
                           {"cpu", LatencyJson(group.cpu)}};
  }
  ordered_json levels = ordered_json::array();
  for (const LevelSize& level : figures.levels) {
    levels.push_back({{"nodes", level.nodes}, {"edges", level.edges}});
  }
  ordered_json comparisons = ordered_json::array();
  for (const FullComparison& comparison : result.comparisons) {
    comparisons.push_back(ComparisonJson(comparison));
  }
  ordered_json json = {{"input", figures.names.input},
                       {"settings", SettingsJson(figures)},
                       {"interrupted", result.interrupted},
                       {"nodes", figures.nodes},
                       {"edges", figures.edges},
                       {"updates", result.updates},
                       {"failed_updates", result.failed_updates},
                       {"seconds", result.seconds},
                       {"latency_ms", latency},
                       {"breakdown_ms",
                        {{"mean", BreakdownJson(figures.statistics.mean)},
                         {"worst_update", figures.statistics.worst_update},
                         {"worst", BreakdownJson(figures.statistics.worst)}}},
                       {"work",
                        {{"windows", result.windows},
                         {"top_solves", result.top_solves},
                         {"solved_nodes", result.solved_nodes},
                         {"merged_edges", result.merged_edges},
                         {"examined_edges", result.examined_edges}}},
                       {"levels", levels},
                       {"bytes_per_node", BytesPerNode(figures)},
                       {"peak_memory_bytes", result.peak_memory},
                       {"chi2", figures.chi2},
                       {"cost", figures.cost},
                       {"comparisons", comparisons}};
  if (figures.settings.compare_closures > 0) json["closing"] = ClosuresJson(result.closures);
  if (result.refine.has_value()) json["refine"] = RefineJson(*result.refine);
  if (figures.reference.has_value()) {
    json["reference"] = {{"poses", figures.reference->poses},
                         {"ate_m", figures.reference->ate_m},
                         {"ate_rad", figures.reference->ate_rad}};
  }
  if (figures.recovery.has_value()) {
    const Recovery& recovery = *figures.recovery;
    ordered_json points = ordered_json::array();
    for (const RecoveryPoint& point : recovery.points) {
      points.push_back({{"updates", point.updates}, {"gap_percent", point.gap_percent}});
    }
    json["far_closure"] = {{"edge", recovery.edge},
                           {"offset_m", recovery.offset_m},
                           {"edge_chi2", recovery.edge_chi2},
                           {"optimum", recovery.optimum},
                           {"slowest_ms", recovery.slowest_ms},
                           {"at_rest", recovery.at_rest},
                           {"points", points}};
  }
  return json;
}

hpgo::Status CheckSummaryCsv(const std::string& path) {
  ReplayFigures none;
  none.statistics = SummarizeUpdates({});
  return OldSummaries(SummaryLines(none).first, path).status();
}

hpgo::Status AppendSummaryCsv(const ReplayFigures& figures, const std::string& path) {
  const auto [header, line] = SummaryLines(figures);
  const hpgo::Result<std::string> old = OldSummaries(header, path);
  if (!old.ok()) return old.status();
  return hpgo::WriteTextFile(path, *old + line);
}

}  // namespace hpgo_cli
