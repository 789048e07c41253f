// hpgo plot: a picture of a graph, or of two side by side.
#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "hpgo/evaluate/chi2.h"
#include "hpgo/graph/compose_poses.h"
#include "hpgo/io/output_file.h"
#include "hpgo/report/graph_plot.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/read_graph.h"

DEFINE_int32(width, hpgo::GraphPlotOptions().width, "the picture's width in pixels");

namespace hpgo_cli {
namespace {

std::string BaseName(const std::string& path) {
  return path == "-" ? "standard input" : path.substr(path.rfind('/') + 1);
}

template <typename G>
hpgo::Result<hpgo::PlotGraph> ToPlotGraph(hpgo::PoseGraph<G>* graph, const std::string& path) {
  hpgo::ComposeMissingPoses(graph);
  hpgo::Result<hpgo::PlotGraph> plot = hpgo::MakePlotGraph(*graph, BaseName(path));
  if (plot.ok() && !graph->edges().empty()) plot->chi2 = hpgo::EvaluateChi2(*graph).total;
  return plot;
}

int RunPlot(const std::vector<std::string>& arguments) {
  if (FLAGS_output.empty()) return FailUsage("--output=FILE.svg is required");
  if (std::count(arguments.begin(), arguments.end(), "-") > 1) {
    return FailUsage("the standard input can be read only once");
  }
  std::vector<hpgo::PlotGraph> graphs;
  for (const std::string& path : arguments) {
    hpgo::Result<hpgo::AnyGraphFile> file = ReadGraph(path, nullptr);
    if (!file.ok()) return Fail(file.status());
    hpgo::Result<hpgo::PlotGraph> plot =
        std::visit([&path](auto& any) { return ToPlotGraph(&any.graph, path); }, *file);
    if (!plot.ok()) return Fail(plot.status());
    graphs.push_back(*std::move(plot));
  }
  if (graphs.front().is_3d != graphs.back().is_3d) {
    return FailUsage(arguments[0] + " and " + arguments[1] + " are of different dimensions");
  }
  hpgo::GraphPlotOptions options;
  options.title = FLAGS_title;
  options.width = FLAGS_width;
  const hpgo::Result<std::string> svg = hpgo::GraphPlotSvg(graphs, options);
  if (!svg.ok()) return Fail(svg.status());
  const hpgo::Status status = hpgo::WriteTextFile(FLAGS_output, *svg);
  if (!status.ok()) return Fail(status);
  if (FLAGS_output != "-") {
    Message("wrote " + FLAGS_output + " (" + FormatCount(static_cast<std::int64_t>(svg->size())) +
            " bytes)");
  }
  return kExitOk;
}

}  // namespace

const Command& PlotCommand() {
  static const Command* command = new Command{
      "plot",
      "INPUT [OTHER]",
      "Draws the trajectory and the loop closures of a graph, or of two side by side, as SVG.",
      1,
      2,
      {"output", "title", "width", "strict", "project_information", "identity_information",
       "create_missing", "row_major_edge2"},
      RunPlot,
      "A 2D graph is drawn as a map, a 3D graph in an oblique parallel view. Two graphs are\n"
      "seen from the same direction. The chi2 under a graph's name is in g2o's convention.\n"
      "Poses that the file does not give are composed from its edges.\n"
      "\n"
      "  hpgo plot map.g2o optimized.g2o --output=map.svg --title=\"Before and after\"\n"};
  return *command;
}

}  // namespace hpgo_cli
