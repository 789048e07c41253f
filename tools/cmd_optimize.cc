#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "ceres_costs/losses.h"
#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/output_file.h"
#include "hpgo/solve/full_solve.h"
#include "hpgo/solve/solver_factory.h"
#include "nlohmann/json.hpp"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/edge_report.h"
#include "tools/optimize_report.h"
#include "tools/read_graph.h"
#include "tools/signals.h"
#include "tools/upright_file.h"

DEFINE_bool(edge_report, false, "print the ten edges with the largest chi2 after the optimization");

namespace hpgo_cli {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::ordered_json;

constexpr int kReportedEdges = 10;

double SecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

// The options the flags ask for; false after a message if one of them has no such value.
bool OptionsFromFlags(hpgo::FullSolveOptions* options) {
  const std::optional<hpgo::InitMethod> init = hpgo::ParseInitMethod(FLAGS_init);
  if (!init.has_value()) {
    FailUsage("--init=" + FLAGS_init +
              ": must be file, odometry, spanning_tree, chordal, joint_chordal or auto");
    return false;
  }
  const std::optional<hpgo::Engine> engine = hpgo::ParseEngine(FLAGS_engine);
  if (!engine.has_value()) {
    FailUsage("--engine=" + FLAGS_engine + ": must be ceres or block");
    return false;
  }
  if (FLAGS_error != "g2o" && FLAGS_error != "log") {
    FailUsage("--error=" + FLAGS_error + ": must be g2o or log");
    return false;
  }
  if (FLAGS_loss_on != "closures" && FLAGS_loss_on != "all") {
    FailUsage("--loss_on=" + FLAGS_loss_on + ": must be closures or all");
    return false;
  }
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  if (!ceres_costs::MakeLoss(FLAGS_loss, FLAGS_loss_scale, &loss, &error)) {
    FailUsage("--loss: " + error);
    return false;
  }
  if (const std::string problem = DofFlagProblem(); !problem.empty()) {
    FailUsage(problem);
    return false;
  }
  if (FLAGS_max_iterations < 0) {
    FailUsage("--max_iterations=" + std::to_string(FLAGS_max_iterations) +
              ": must not be negative");
    return false;
  }
  if (!(FLAGS_max_seconds >= 0)) {
    FailUsage("--max_seconds=" + std::to_string(FLAGS_max_seconds) + ": must not be negative");
    return false;
  }
  if (FLAGS_output == "-" && FLAGS_stats_json == "-") {
    FailUsage("--output and --stats_json cannot both be the standard output");
    return false;
  }
  options->init = *init;
  options->engine = *engine;
  options->convention = ConventionOfFlag();
  options->loss = FLAGS_loss;
  options->loss_scale = FLAGS_loss_scale;
  options->loss_on =
      FLAGS_loss_on == "all" ? hpgo::LossScope::kAllEdges : hpgo::LossScope::kLoopClosures;
  options->max_iterations = FLAGS_max_iterations;
  options->max_seconds = FLAGS_max_seconds;
  options->cancel = &CancelFlag();
  return true;
}

// Optimizes `graph` and writes; `json` gets what --stats_json prints. `write` brings the result
// into the file.
template <typename G>
int OptimizeGraph(hpgo::FullSolveOptions options, hpgo::PoseGraph<G>* graph, ordered_json* json,
                  const std::function<hpgo::Status()>& write) {
  hpgo::FullSolveReport report;
  {
    Progress progress;
    if (progress.enabled()) {
      options.progress = [&progress](int iteration, double cost) {
        progress.Show("iteration " + std::to_string(iteration) + ", cost " + FormatNumber(cost));
      };
    }
    report = hpgo::SolveFull(options, graph);
  }
  json->update(ResultJson(report));
  const bool interrupted = report.status.code() == hpgo::StatusCode::kInterrupted;
  if (!report.status.ok() && !interrupted) return Fail(report.status);

  if (interrupted) Warn("interrupted; the result is the best so far");
  DescribeResult(report);
  if (FLAGS_edge_report) {
    const std::vector<ReportedEdge> worst =
        FindWorstEdges(*graph, options.convention, kReportedEdges);
    // A result, but never between the lines of another one.
    const bool stdout_taken = FLAGS_output == "-" || FLAGS_stats_json == "-";
    PrintWorstEdges(worst, report.chi2_after, stdout_taken ? Message : Print);
    (*json)["worst_edges"] = WorstEdgesJson(worst);
  }
  if (!FLAGS_output.empty()) {
    const hpgo::Status written = write();
    if (!written.ok()) return Fail(written);
    if (FLAGS_output != "-") Message("wrote " + FLAGS_output);
  }
  if (interrupted) return kExitInterrupted;
  if (report.converged) return kExitOk;
  Warn("a limit ended the optimization before it converged; the result is usable");
  return kExitLimit;
}

template <typename G>
int OptimizeFile(const std::string& input, const hpgo::FullSolveOptions& options,
                 hpgo::GraphFile<G>* file, ordered_json* json) {
  if constexpr (G::kDim == 3) {
    if (FLAGS_dof == 4) {
      hpgo::Result<hpgo::UprightGraph> upright = MakeUpright(file->graph, input);
      if (!upright.ok()) return Fail(upright.status());
      return OptimizeGraph(options, &upright->graph, json, [&] {
        file->graph = WithUprightPoses(file->graph, *upright, upright->graph);
        return hpgo::WriteG2o(*file, FLAGS_output);
      });
    }
  }
  return OptimizeGraph(options, &file->graph, json,
                       [&] { return hpgo::WriteG2o(*file, FLAGS_output); });
}

int Run(const std::vector<std::string>& arguments) {
  hpgo::FullSolveOptions options;
  if (!OptionsFromFlags(&options)) return kExitUsage;
  const std::string& input = arguments[0];
  const Clock::time_point begin = Clock::now();
  hpgo::ReadReport report;
  hpgo::Result<hpgo::AnyGraphFile> file = ReadGraph(input, &report);
  if (!file.ok()) return Fail(file.status());
  const double read_seconds = SecondsSince(begin);

  return std::visit(
      [&](auto& graph_file) {
        const auto& graph = graph_file.graph;
        using G = typename std::decay_t<decltype(graph)>::Group;
        InputFigures figures;
        figures.name = input;
        figures.dimension = G::kDim;
        figures.nodes = graph.nodes().size();
        figures.edges = graph.edges().size();
        figures.priors = graph.priors().size();
        figures.seconds = read_seconds;
        DescribeInput(figures, report);
        ordered_json json;
        json["input"] = InputJson(figures, report);
        const std::string misfit = DofMisfit(G::kDim, input);
        if (!misfit.empty()) return FailUsage(misfit);
        const int exit_code = OptimizeFile(input, options, &graph_file, &json);
        json["seconds"]["read"] = read_seconds;
        json["exit_code"] = exit_code;
        if (FLAGS_stats_json.empty()) return exit_code;
        const hpgo::Status written = hpgo::WriteTextFile(FLAGS_stats_json, json.dump(2) + "\n");
        return written.ok() ? exit_code : Fail(written);
      },
      *file);
}

}  // namespace

const Command& OptimizeCommand() {
  static const Command* command = new Command{
      "optimize",
      "INPUT",
      "Moves the poses of a g2o or TORO file to where its edges agree best.",
      1,
      1,
      {"output", "stats_json", "init", "engine", "dof", "error", "loss", "loss_scale", "loss_on",
       "max_iterations", "max_seconds", "edge_report", "strict", "project_information",
       "identity_information", "create_missing", "row_major_edge2"},
      &Run,
      "Prints what it read, the chi2 before and after, iterations and time. Fixed "
      "nodes (FIX) stay;\n"
      "a component with neither a fixed node nor a prior keeps its first node. Ctrl-C "
      "once ends it\n"
      "after the current iteration and writes what there is (exit code 130).\n\n"
      "With --dof=4 roll and pitch stay as the file's vertices have them, in a world whose z is "
      "up: each\nmeasurement is turned by them into gravity-aligned frames, and what its "
      "information "
      "says of x, y, z\nand yaw there is kept. The chi2 is of these four.\n\n"
      "Examples:\n"
      "  hpgo optimize map.g2o --output=optimized.g2o\n"
      "  hpgo optimize map.g2o --loss=dcs --edge_report --stats_json=stats.json\n"
      "  hpgo optimize vio.g2o --dof=4 --output=optimized.g2o\n"};
  return *command;
}

}  // namespace hpgo_cli
