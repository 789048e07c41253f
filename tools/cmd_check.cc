#include <string>
#include <variant>
#include <vector>

#include "hpgo/graph/components.h"
#include "hpgo/graph/edge_classes.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/line_fields.h"
#include "hpgo/io/record_tags.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/read_graph.h"

namespace hpgo_cli {
namespace {

// "VERTEX_SE2 3,500, EDGE_SE2 5,453".
std::string TagCounts(const hpgo::ReadReport& report) {
  constexpr std::size_t kShown = 30;
  std::string text;
  std::size_t shown = 0;
  for (const auto& [tag, count] : report.tags) {
    if (shown == kShown) {
      return text + ", " +
             Plural(static_cast<std::int64_t>(report.tags.size() - shown), "other tag");
    }
    text += (text.empty() ? "" : ", ") + hpgo::Shortened(tag) + " " + FormatCount(count);
    ++shown;
  }
  return text.empty() ? "no records" : text;
}

template <typename G>
void PrintGraph(const hpgo::PoseGraph<G>& graph, const hpgo::ReadReport& report) {
  std::int64_t closures = 0, fixed = 0;
  for (const bool closure : hpgo::LoopClosures(graph)) closures += closure;
  for (const hpgo::GraphNode<G>& node : graph.nodes()) fixed += node.fixed;
  Print((G::kDim == 2 ? "2D, " : "3D, ") +
        Plural(static_cast<std::int64_t>(graph.nodes().size()), "node") + " (" +
        FormatCount(fixed) + " fixed), " +
        Plural(static_cast<std::int64_t>(graph.edges().size()), "edge") + " (" +
        Plural(closures, "loop closure") + "), " +
        Plural(static_cast<std::int64_t>(graph.priors().size()), "prior") + ", " +
        Plural(hpgo::FindComponents(graph).count, "component"));
  if (report.edges_only) Print("no vertices: poses are composed from the edges");
}

// What was accepted but is worth knowing.
void PrintOddities(const hpgo::ReadReport& report) {
  const auto line = [](std::int64_t count, const std::string& noun, const std::string& what) {
    if (count > 0) Print(Plural(count, noun) + " " + what);
  };
  line(report.unknown, "line", "of unknown tags, kept as text");
  line(report.landmarks, "line", "of landmarks, kept as text");
  line(report.duplicate_vertices, "vertex line", "repeated, left out");
  line(report.normalized_quaternions, "quaternion", "normalized");
  line(report.semidefinite_informations, "information", "without full rank");
  line(report.projected_informations, "information", "projected");
  line(report.identity_informations, "information", "missing, the identity taken");
  line(report.merged_nodes, "vertex line", "of merged nodes (EQUIV)");
  line(report.created_nodes, "missing pose", "composed");
  line(report.priors_without_offset, "prior", "without parameter");
}

int Run(const std::vector<std::string>& arguments) {
  hpgo::ReadOptions options = ReadOptionsFromFlags();
  options.collect_all_problems = true;
  hpgo::ReadReport report;
  const hpgo::Result<hpgo::AnyGraphFile> file = hpgo::ReadG2o(arguments[0], options, &report);
  if (!file.ok() && file.status().code() != hpgo::StatusCode::kMalformed) {
    return Fail(file.status());
  }
  for (const std::string& warning : report.warnings) Warn(warning);
  for (const std::string& problem : report.problems) Print(problem);
  if (report.lines > 0) Print(Plural(report.lines, "line") + ": " + TagCounts(report));
  if (file.ok()) {
    std::visit([&](const auto& any) { PrintGraph(any.graph, report); }, *file);
  }
  PrintOddities(report);
  Print(Plural(static_cast<std::int64_t>(report.problems.size()), "problem") + ", " +
        Plural(static_cast<std::int64_t>(report.warnings.size()), "warning"));
  return file.ok() ? kExitOk : kExitMalformed;
}

}  // namespace

const Command& CheckCommand() {
  static const std::string help =
      "The problems and a summary go to the standard output, warnings to the standard error. The\n"
      "exit code is 0 if the file can be used, 3 if it cannot, 2 if it cannot be read. Files\n"
      "compressed with gzip are read as they are.\n\n" +
      hpgo::RecordTagList() +
      "\n"
      "The information of EDGE2 and EDGE is in TORO's order unless --row_major_edge2 is given; "
      "that\n"
      "of ODOMETRY is iSAM's square root. EQUIV makes the two nodes one.\n"
      "\n"
      "  hpgo check map.g2o\n"
      "  hpgo check --strict map.g2o\n";
  static const Command* command =
      new Command{"check",
                  "INPUT",
                  "Reads a g2o or TORO file and lists every problem with its line.",
                  1,
                  1,
                  {"strict", "project_information", "identity_information", "create_missing",
                   "row_major_edge2"},
                  &Run,
                  help};
  return *command;
}

}  // namespace hpgo_cli
