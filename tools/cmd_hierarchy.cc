#include <algorithm>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "hpgo/graph/compose_poses.h"
#include "hpgo/hierarchy/consistency.h"
#include "hpgo/io/output_file.h"
#include "nlohmann/json.hpp"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/hierarchy_build.h"
#include "tools/read_graph.h"
#include "tools/replay_report.h"

namespace {
// Defaults stand in the options alone.
const hpgo::HierarchyOptions kDefaults;
}  // namespace

DEFINE_int32(max_group_size, kDefaults.max_group_size, "the largest number of nodes of a group");
DEFINE_string(coarse_edges, "galerkin",
              "how the edges between groups are computed: galerkin or condensed (the paper's)");

namespace hpgo_cli {
namespace {

using nlohmann::ordered_json;

struct Figures {
  std::string input;
  hpgo::HierarchyOptions options;
  std::vector<LevelFigures> levels;
  LatencyFigures insert_us;
  std::int64_t coarse_edges = 0;
  double coarse_us_each = 0;
};

void PrintFigures(const Figures& figures, void (*print_line)(const std::string&)) {
  std::vector<std::string> head = {"nodes", "edges", "of all", "reduction", "Q"};
  for (int size = 1; size <= figures.options.max_group_size; ++size) {
    head.push_back("of " + std::to_string(size));
  }
  print_line(TableRow("level", head));
  for (std::size_t l = 0; l < figures.levels.size(); ++l) {
    const LevelFigures& level = figures.levels[l];
    std::vector<std::string> cells = {FormatCount(level.nodes), FormatCount(level.edges),
                                      FormatAs("%.2f %%", 100 * level.fraction),
                                      l > 0 ? FormatAs("%.3f", level.reduction) : "-"};
    if (!level.group_sizes.empty()) {
      cells.push_back(FormatAs("%.4f", level.modularity));
      for (const std::int64_t count : level.group_sizes) cells.push_back(FormatCount(count));
    }
    print_line(TableRow(std::to_string(l), cells));
  }
  print_line("Q: modularity of the level's groups; of 1, 2, ...: groups with so many members");
  print_line("insertion of a node: median " + FormatAs("%.3g", figures.insert_us.p50) +
             " us, p99 " + FormatAs("%.3g", figures.insert_us.p99) + " us, max " +
             FormatAs("%.3g", figures.insert_us.max) + " us");
  print_line(Plural(figures.coarse_edges, "coarse edge") + " (" + FLAGS_coarse_edges + "), " +
             FormatAs("%.3g", figures.coarse_us_each) + " us each");
}

ordered_json FiguresJson(const Figures& figures) {
  ordered_json levels = ordered_json::array();
  for (const LevelFigures& level : figures.levels) {
    levels.push_back({{"nodes", level.nodes},
                      {"edges", level.edges},
                      {"fraction", level.fraction},
                      {"reduction", level.reduction},
                      {"modularity", level.modularity},
                      {"groups_by_size", level.group_sizes}});
  }
  return {{"input", figures.input},
          {"max_group_size", figures.options.max_group_size},
          {"max_top_nodes", figures.options.max_top_nodes},
          {"levels", levels},
          {"insertion_us",
           {{"mean", figures.insert_us.mean},
            {"p50", figures.insert_us.p50},
            {"p99", figures.insert_us.p99},
            {"max", figures.insert_us.max}}},
          {"coarse_edges",
           {{"kind", FLAGS_coarse_edges},
            {"count", figures.coarse_edges},
            {"us_each", figures.coarse_us_each}}}};
}

template <typename G>
hpgo::Status WritePicture(const hpgo::PoseGraph<G>& graph, const BuiltHierarchy<G>& built,
                          const std::string& input) {
  const hpgo::Result<hpgo::PlotGraph> plot = hpgo::MakePlotGraph(graph, input);
  if (!plot.ok()) return plot.status();
  hpgo::HierarchyPlotOptions options;
  options.title = FLAGS_title;
  const hpgo::Result<std::string> svg = hpgo::HierarchyPlotSvg(*plot, PlotLevels(built), options);
  if (!svg.ok()) return svg.status();
  const hpgo::Status written = hpgo::WriteTextFile(FLAGS_output, *svg);
  if (written.ok() && FLAGS_output != "-") {
    Message("wrote " + FLAGS_output + " (" + FormatCount(static_cast<std::int64_t>(svg->size())) +
            " bytes)");
  }
  return written;
}

template <typename G>
int ShowHierarchy(const std::string& input, const hpgo::HierarchyOptions& options,
                  hpgo::PoseGraph<G>* graph) {
  if (hpgo::ComposeMissingPoses(graph) > 0) {
    Message("no vertices: poses are composed from the edges");
  }
  const BuiltHierarchy<G> built = BuildIncrementally(*graph, options);
  const std::string inconsistency = hpgo::FindInconsistency(*built.hierarchy);
  if (!inconsistency.empty()) {
    Error("the hierarchy is not consistent: " + inconsistency);
    return kExitNoSolution;
  }
  Figures figures;
  figures.input = input;
  figures.options = options;
  figures.levels = FiguresOf(*built.hierarchy);
  figures.insert_us = SummarizeLatency(built.insert_us);
  figures.coarse_edges = built.coarse_edges;
  figures.coarse_us_each = 1e6 * built.coarse_seconds /
                           static_cast<double>(std::max<std::int64_t>(1, built.coarse_edges));
  PrintFigures(figures, FLAGS_output == "-" || FLAGS_json == "-" ? Message : Print);
  hpgo::Status status;
  if (!FLAGS_output.empty()) status = WritePicture(*graph, built, input);
  if (status.ok() && !FLAGS_json.empty()) {
    status = hpgo::WriteTextFile(FLAGS_json, FiguresJson(figures).dump(2) + "\n");
  }
  return status.ok() ? int{kExitOk} : Fail(status);
}

int Run(const std::vector<std::string>& arguments) {
  hpgo::HierarchyOptions options;
  options.max_group_size = FLAGS_max_group_size;
  if (FLAGS_max_top_nodes != 0) options.max_top_nodes = FLAGS_max_top_nodes;
  if (FLAGS_max_top_edges != 0) options.max_top_edges = FLAGS_max_top_edges;
  if (options.max_group_size < 2) {
    return FailUsage("--max_group_size=" + std::to_string(FLAGS_max_group_size) +
                     ": must be at least 2");
  }
  if (options.max_top_nodes < 2) {
    return FailUsage("--max_top_nodes=" + std::to_string(FLAGS_max_top_nodes) +
                     ": must be at least 2");
  }
  if (options.max_top_edges < 1) {
    return FailUsage("--max_top_edges=" + std::to_string(FLAGS_max_top_edges) +
                     ": must be at least 1");
  }
  if (FLAGS_coarse_edges == "condensed") {
    options.coarse_edges = hpgo::CoarseEdges::kCondensed;
  } else if (FLAGS_coarse_edges != "galerkin") {
    return FailUsage("--coarse_edges=" + FLAGS_coarse_edges + ": must be galerkin or condensed");
  }
  if (FLAGS_output == "-" && FLAGS_json == "-") {
    return FailUsage("--output and --json cannot both be the standard output");
  }
  hpgo::Result<hpgo::AnyGraphFile> file = ReadGraph(arguments[0], nullptr);
  if (!file.ok()) return Fail(file.status());
  return std::visit([&](auto& any) { return ShowHierarchy(arguments[0], options, &any.graph); },
                    *file);
}

}  // namespace

const Command& HierarchyCommand() {
  static const Command* command = new Command{
      "hierarchy",
      "INPUT",
      "Grows the hierarchy of groups over a graph node by node; figures and a picture of it.",
      1,
      1,
      {"output", "json", "title", "max_group_size", "max_top_nodes", "max_top_edges",
       "coarse_edges", "strict", "project_information", "identity_information", "create_missing",
       "row_major_edge2"},
      &Run,
      "Prints for each level its size, also relative to the graph, the reduction from the level "
      "below, the\nmodularity of its groups and how many of them have 1, 2, ... members; the time "
      "to insert a node and\nto compute a coarse edge. --output draws the hierarchy over the "
      "trajectory, one colour a group, at\nthe file's poses: the picture is clearest for an "
      "optimized file.\n\n"
      "Examples:\n"
      "  hpgo hierarchy map.g2o --output=hierarchy.svg\n"
      "  hpgo hierarchy map.g2o --max_top_nodes=300 --coarse_edges=condensed --json=-\n"};
  return *command;
}

}  // namespace hpgo_cli
