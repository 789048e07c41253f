#include "tools/replay_report.h"

#include <algorithm>
#include <cstdio>

#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/solve/solver_factory.h"
#include "tools/console.h"

namespace hpgo_cli {
namespace {

std::vector<std::string> BreakdownCells(const UpdateBreakdown& breakdown) {
  std::vector<std::string> cells;
  for (const auto& [name, part] : BreakdownParts())
    cells.push_back(FormatAs("%.3g", breakdown.*part));
  return cells;
}

std::string ComparisonText(const FullComparison& comparison) {
  return "gap " + FormatAs("%.3g", comparison.gap_percent) + " %, ATE to the optimum " +
         FormatAs("%.3g", comparison.ate_m) + " m (cost " + FormatNumber(comparison.cost) +
         ", optimum " + FormatNumber(comparison.optimum) + " from " +
         (comparison.start == "chordal" ? "a chordal start" : "the estimate") + ")";
}

void PrintLatencies(const ReplayStatistics& statistics,
                    const std::function<void(const std::string&)>& print_line) {
  std::vector<std::string> head = {"updates"};
  for (const char* clock : {" wall", " cpu"}) {
    for (const auto& [name, quantile] : LatencyQuantiles())
      head.push_back(std::string(name) + clock);
  }
  print_line(TableRow("latency, ms", head));
  for (const UpdateGroup& group : statistics.groups) {
    std::vector<std::string> cells = {FormatCount(group.count)};
    for (const LatencyFigures* latency : {&group.wall, &group.cpu}) {
      for (const auto& [name, quantile] : LatencyQuantiles()) {
        cells.push_back(group.count > 0 ? FormatAs("%.3g", latency->*quantile) : "-");
      }
    }
    print_line(TableRow("  " + group.name, cells));
  }
  std::vector<std::string> parts;
  for (const auto& [name, part] : BreakdownParts()) parts.push_back(name);
  print_line(TableRow("wall time, ms", parts));
  print_line(TableRow("  mean", BreakdownCells(statistics.mean)));
  print_line(TableRow("  worst", BreakdownCells(statistics.worst)) + "  (update " +
             FormatCount(statistics.worst_update) + ")");
}

void PrintLevels(const std::vector<LevelSize>& levels,
                 const std::function<void(const std::string&)>& print_line) {
  std::string text = "levels over the kept nodes, nodes/edges:";
  for (const LevelSize& level : levels) {
    text += " " + FormatCount(level.nodes) + "/" + FormatCount(level.edges);
  }
  print_line(text);
}

void PrintClosures(const ClosureFigures& closures,
                   const std::function<void(const std::string&)>& print_line) {
  std::vector<std::string> head, gaps, distances;
  const Distribution gap = closures.gap_percent(), ate = closures.ate_m();
  for (const auto& [name, figure] : DistributionFigures()) {
    head.push_back(name);
    gaps.push_back(FormatAs("%.3g", gap.*figure));
    distances.push_back(FormatAs("%.3g", ate.*figure));
  }
  print_line("right after " + FormatCount(static_cast<std::int64_t>(closures.comparisons.size())) +
             " of " + Plural(closures.closing_updates, "update") + " with a loop closure:");
  print_line(TableRow("to the optimum", head));
  print_line(TableRow("  gap, %", gaps));
  print_line(TableRow("  ATE, m", distances));
}

}  // namespace

template <typename G>
std::vector<LevelSize> LevelSizes(const hpgo::Hierarchy<G>& hierarchy) {
  std::vector<LevelSize> sizes;
  for (int l = 0; l < hierarchy.num_levels(); ++l) {
    sizes.push_back({hierarchy.level(l).num_nodes, hierarchy.level(l).num_edges});
  }
  return sizes;
}

double BytesPerNode(const ReplayFigures& figures) {
  return static_cast<double>(figures.result.optimizer_memory) /
         static_cast<double>(std::max<std::int64_t>(1, figures.nodes));
}

std::string TableRow(const std::string& name, const std::vector<std::string>& cells) {
  constexpr std::size_t kNameWidth = 16, kWidth = 9;
  std::string row = name;
  row.resize(std::max(kNameWidth, name.size() + 1), ' ');
  for (const std::string& cell : cells) {
    row += std::string(cell.size() < kWidth ? kWidth - cell.size() : 1, ' ') + cell;
  }
  return row;
}

std::string BaseName(const std::string& path) { return path.substr(path.rfind('/') + 1); }

std::string FormatAs(const char* format, double value) {
  char text[48];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

void PrintReplay(const ReplayFigures& figures,
                 const std::function<void(const std::string&)>& print_line) {
  const ReplayResult& result = figures.result;
  print_line(Plural(result.updates, "update") + " in " + FormatDuration(result.seconds) +
             ": preset " + figures.names.preset + ", engine " +
             hpgo::EngineName(figures.settings.options.engine) + ", mode " + figures.names.mode +
             "; " + Plural(result.windows, "window") + ", " + Plural(result.top_solves, "solve") +
             " of the top");
  PrintLatencies(figures.statistics, print_line);
  PrintLevels(figures.levels, print_line);
  print_line(
      "memory: " + FormatCount(static_cast<std::int64_t>(BytesPerNode(figures))) +
      " bytes a node, at most " +
      FormatAs("%.0f", static_cast<double>(result.peak_memory) / kMegabyte) + " MB with the input" +
      (result.comparisons.empty() && result.closures.comparisons.empty() ? ""
                                                                         : " and full solves"));
  for (const FullComparison& comparison : result.comparisons) {
    print_line("at " + FormatAs("%g", comparison.percent) + " %: " + ComparisonText(comparison));
  }
  if (!result.closures.comparisons.empty()) PrintClosures(result.closures, print_line);
  if (result.refine.has_value()) {
    const RefineResult& refine = *result.refine;
    std::string text = "refined in " + FormatDuration(refine.report.seconds) + " by " +
                       Plural(refine.report.windows, "window") + " and " +
                       Plural(refine.report.top_solves, "solve") + " of the top" +
                       (refine.report.at_rest ? ", at rest" : ", not at rest");
    if (refine.before.has_value()) {
      text += ": gap " + FormatAs("%.3g", refine.before->gap_percent) + " % before";
    }
    print_line(text);
    if (refine.after.has_value()) print_line("refined: " + ComparisonText(*refine.after));
  }
  print_line("chi2 " + FormatNumber(figures.chi2));
  if (figures.reference.has_value()) {
    print_line("ATE to the reference " + FormatNumber(figures.reference->ate_m) + " m, " +
               FormatNumber(figures.reference->ate_rad) + " rad (" +
               Plural(figures.reference->poses, "pose") + ")");
  }
  if (figures.recovery.has_value()) {
    const Recovery& recovery = *figures.recovery;
    print_line("closure " + recovery.edge + ", " + FormatAs("%.3g", recovery.offset_m) +
               " m off, chi2 " + FormatNumber(recovery.edge_chi2) + ": optimum " +
               FormatNumber(recovery.optimum) + ", slowest update " +
               FormatAs("%.3g", recovery.slowest_ms) + " ms" +
               (recovery.at_rest ? ", at rest" : ""));
    std::vector<std::string> updates, gaps;
    for (const RecoveryPoint& point : recovery.points) {
      updates.push_back(std::to_string(point.updates));
      gaps.push_back(FormatAs("%.3g", point.gap_percent));
    }
    print_line(TableRow("  updates", updates));
    print_line(TableRow("  gap, %", gaps));
  }
}

template std::vector<LevelSize> LevelSizes(const hpgo::Hierarchy<hpgo::SE2>&);
template std::vector<LevelSize> LevelSizes(const hpgo::Hierarchy<hpgo::SE3>&);
template std::vector<LevelSize> LevelSizes(const hpgo::Hierarchy<hpgo::YawPose>&);

}  // namespace hpgo_cli
