#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/output_file.h"
#include "hpgo/io/state_file.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/pose_source.h"
#include "tools/read_graph.h"
#include "tools/replay_flags.h"
#include "tools/replay_report.h"
#include "tools/replay_run.h"
#include "tools/replay_verdict.h"
#include "tools/signals.h"
#include "tools/upright_file.h"

namespace hpgo_cli {
namespace {

using Clock = std::chrono::steady_clock;

// The file with the estimate in place of its poses; after an interrupted replay the nodes so far.
template <typename G>
hpgo::Status WriteEstimate(const hpgo::PoseGraph<G>& estimate, hpgo::GraphFile<G>* file) {
  if (estimate.nodes().size() < file->graph.nodes().size()) {
    hpgo::WriteOptions options;
    options.write_fixed = true;
    return hpgo::WriteG2o(estimate, FLAGS_output, options);
  }
  for (const hpgo::GraphNode<G>& node : estimate.nodes()) {
    hpgo::GraphNode<G>& target = file->graph.node(*file->graph.Find(node.id));
    if (!target.fixed || !target.has_pose) target.pose = node.pose;
    target.has_pose = true;
  }
  return hpgo::WriteG2o(*file, FLAGS_output);
}

hpgo::Status WriteChart(const ReplayFigures& figures) {
  const ClosureFigures& closures = figures.result.closures;
  if (closures.comparisons.empty()) {
    Warn("no chart: there was no loop closure to compare after");
    return hpgo::Status::Ok();
  }
  const hpgo::Result<std::string> svg = ClosureChart(closures, BaseName(figures.names.input));
  if (!svg.ok()) return svg.status();
  const hpgo::Status status = hpgo::WriteTextFile(FLAGS_chart, *svg);
  if (status.ok() && FLAGS_chart != "-") Message("wrote " + FLAGS_chart);
  return status;
}

template <typename G>
hpgo::Status WriteResults(const ReplayFigures& figures, int exit_code,
                          const hpgo::PoseGraph<G>& estimate, hpgo::GraphFile<G>* file) {
  hpgo::Status status;
  if (!FLAGS_output.empty()) {
    status = WriteEstimate(estimate, file);
    if (status.ok() && FLAGS_output != "-") Message("wrote " + FLAGS_output);
  }
  if (status.ok() && !FLAGS_chart.empty()) status = WriteChart(figures);
  if (status.ok() && !FLAGS_stats_json.empty()) {
    nlohmann::ordered_json json = ReplayJson(figures);
    json["exit_code"] = exit_code;
    status = hpgo::WriteTextFile(FLAGS_stats_json, json.dump(2) + "\n");
  }
  if (status.ok() && !FLAGS_summary_csv.empty()) {
    status = AppendSummaryCsv(figures, FLAGS_summary_csv);
  }
  return status;
}

// Of `graph`; `in_file` makes the graph of the file's poses of an estimate.
template <typename G, typename F>
int ReplayGraph(const std::string& input, ReplaySettings settings, const hpgo::PoseGraph<G>& graph,
                const std::optional<PoseSource>& reference,
                const std::function<hpgo::PoseGraph<F>(hpgo::PoseGraph<G>)>& in_file,
                hpgo::GraphFile<F>* file) {
  if (settings.far_closure > 0 &&
      (graph.nodes().size() < kMinFarClosureNodes || graph.edges().empty())) {
    return Fail(hpgo::Status(hpgo::StatusCode::kInvalidArgument,
                             input + ": a far-off closure needs " +
                                 std::to_string(kMinFarClosureNodes) + " nodes and an edge"));
  }
  hpgo::Optimizer<G> optimizer(settings.options);
  if (!FLAGS_resume.empty()) {
    const hpgo::Status resumed = hpgo::LoadState(FLAGS_resume, &optimizer);
    if (!resumed.ok()) return Fail(resumed);
    const std::string conflict = ConflictWithSaved(optimizer.options(), settings.options);
    if (!conflict.empty()) return FailUsage(conflict);
    settings.options = optimizer.options();
    Message("resumed " + FLAGS_resume + " at " + Plural(optimizer.num_nodes(), "node"));
  }
  hpgo::Result<ReplayResult> result = RunReplay(graph, settings, &optimizer);
  if (!result.ok()) return Fail(result.status());

  ReplayFigures figures;
  figures.names = {input, FLAGS_preset,
                   FLAGS_measure_mode.empty() ? FLAGS_mode : FLAGS_measure_mode,
                   settings.solve_every == 0 ? "loop" : std::to_string(settings.solve_every)};
  figures.settings = settings;
  figures.result = *std::move(result);
  figures.statistics = SummarizeUpdates(figures.result.samples);
  figures.nodes = static_cast<std::int64_t>(optimizer.num_nodes());
  figures.edges = static_cast<std::int64_t>(optimizer.num_edges());
  figures.levels = LevelSizes(optimizer.hierarchy());
  figures.cost = optimizer.Cost();
  figures.chi2 = Chi2(optimizer);
  hpgo::PoseGraph<F> estimate;  // a copy of the map: only where it is asked for
  if (!FLAGS_output.empty() || reference.has_value()) estimate = in_file(optimizer.ToGraph());
  if (reference.has_value()) {
    const hpgo::Result<ReferenceError> error = CompareWithReference(estimate, input, *reference);
    if (!error.ok()) return Fail(error.status());
    figures.reference = *error;
  }
  if (settings.far_closure > 0 && !figures.result.interrupted) {
    hpgo::UpdateLimits limits;
    limits.max_seconds = settings.update_seconds;
    limits.cancel = &CancelFlag();
    hpgo::Result<Recovery> recovery =
        RecoverFromFarClosure(graph, settings.far_closure, limits, settings.loss, &optimizer);
    figures.result.interrupted = CancelFlag();
    if (recovery.ok()) {
      figures.recovery = *std::move(recovery);
    } else if (!figures.result.interrupted) {
      figures.recovery_failure = recovery.status();
    }
  }
  const bool stdout_taken = FLAGS_output == "-" || FLAGS_stats_csv == "-" ||
                            FLAGS_stats_json == "-" || FLAGS_chart == "-";
  PrintReplay(figures, stdout_taken ? Message : Print);
  const int exit_code = JudgeReplay(figures);
  const hpgo::Status written = WriteResults(figures, exit_code, estimate, file);
  return written.ok() ? exit_code : Fail(written);
}

template <typename G>
int ReplayFile(const std::string& input, const ReplaySettings& settings,
               const std::optional<PoseSource>& reference, hpgo::GraphFile<G>* file) {
  if constexpr (G::kDim == 3) {
    if (FLAGS_dof == 4) {
      const hpgo::Result<hpgo::UprightGraph> upright = MakeUpright(file->graph, input);
      if (!upright.ok()) return Fail(upright.status());
      return ReplayGraph<hpgo::YawPose, G>(
          input, settings, upright->graph, reference,
          [&](const hpgo::PoseGraph<hpgo::YawPose>& estimate) {
            return WithUprightPoses(file->graph, *upright, estimate);
          },
          file);
    }
  }
  return ReplayGraph<G, G>(
      input, settings, file->graph, reference, [](hpgo::PoseGraph<G> estimate) { return estimate; },
      file);
}

int Run(const std::vector<std::string>& arguments) {
  std::string problem;
  const ReplaySettings settings = ReplaySettingsFromFlags(&problem);
  if (problem.empty()) problem = DofFlagProblem();
  if (!problem.empty()) return FailUsage(problem);
  const std::string& input = arguments[0];
  if ((input == "-") + (FLAGS_reference == "-") + (FLAGS_resume == "-") > 1) {
    return FailUsage("only one file can be the standard input");
  }
  if (!FLAGS_summary_csv.empty()) {
    const hpgo::Status fits = CheckSummaryCsv(FLAGS_summary_csv);
    if (!fits.ok()) return Fail(fits);
  }
  const Clock::time_point begin = Clock::now();
  hpgo::Result<hpgo::AnyGraphFile> file = ReadGraph(input, nullptr);
  if (!file.ok()) return Fail(file.status());
  const double read_seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  std::optional<PoseSource> reference;
  if (!FLAGS_reference.empty()) {
    hpgo::Result<PoseSource> source = ReadPoseSource(FLAGS_reference);
    if (!source.ok()) return Fail(source.status());
    reference = *std::move(source);
  }
  return std::visit(
      [&](auto& graph_file) {
        const auto& graph = graph_file.graph;
        using G = typename std::decay_t<decltype(graph)>::Group;
        Message("read " + Bold(input) + ": " + std::to_string(G::kDim) + "D, " +
                Plural(graph.nodes().size(), "node") + ", " + Plural(graph.edges().size(), "edge") +
                ", " + Plural(graph.priors().size(), "prior") + " in " +
                FormatDuration(read_seconds));
        const std::string misfit = DofMisfit(G::kDim, input);
        if (!misfit.empty()) return FailUsage(misfit);
        return ReplayFile(input, settings, reference, &graph_file);
      },
      *file);
}

}  // namespace

const Command& ReplayCommand() {
  static const Command* command = new Command{
      "replay",
      "INPUT",
      "Feeds a recorded graph node by node, each followed by one bounded update.",
      1,
      1,
      {"solve_every",
       "update_at",
       "stale_poses",
       "mode",
       "preset",
       "engine",
       "dof",
       "error",
       "window_nodes",
       "max_top_nodes",
       "max_top_edges",
       "max_windows",
       "stress_threshold",
       "update_seconds",
       "loss",
       "loss_scale",
       "output",
       "stats_csv",
       "chi2_every",
       "stats_json",
       "summary_csv",
       "compare_full",
       "compare_at",
       "chart",
       "compare_threshold",
       "stats_from",
       "measure_mode",
       "measure_updates",
       "refine",
       "save",
       "save_every",
       "resume",
       "far_closure",
       "reference",
       "plane",
       "by_order",
       "strict",
       "project_information",
       "identity_information",
       "create_missing",
       "row_major_edge2"},
      &Run,
      "Nodes arrive in the order of their ids, each with its edges to earlier ones. A new node "
      "starts at\nan earlier neighbour's estimate composed with the edge between them; the file's "
      "poses are not used.\nPrints latencies (wall and CPU time of adding a node and updating), "
      "where the time went, the levels\nand the memory. --loss is for loop closures. Fixed nodes "
      "(FIX) start at the file's pose and stay.\nCtrl-C once ends the replay and writes what there "
      "is (exit code 130).\n\n"
      "The gap is that of the cost to the full optimum, the lower of two full solves: from the "
      "estimate\nand from a chordal start; with --compare_at from the estimate and from the "
      "optimum "
      "before, its new nodes\ncomposed from their edges. Time and memory of comparisons are not "
      "those of the "
      "replay: measure\nmemory without.\n\n"
      "With --dof=4 x, y, z and yaw are estimated, and roll and pitch are those of the file's "
      "vertices, in\na world whose z is up: each measurement is turned by them into "
      "gravity-aligned "
      "frames, and what its\ninformation says of x, y, z and yaw there is kept. Costs and gaps are "
      "those of the four; the estimate\nis written with the known roll and pitch.\n\n"
      "Examples:\n"
      "  hpgo replay map.g2o --compare_full=25,50,75,100 --stats_csv=updates.csv\n"
      "  hpgo replay map.g2o --compare_at=closures --chart=gaps.svg\n"
      "  hpgo replay map.g2o --preset=paper --output=estimate.g2o\n"
      "  hpgo replay kitti_00.g2o --reference=00.txt --plane=xz --refine\n"
      "  hpgo replay map.g2o --measure_mode=full --measure_updates=5\n"};
  return *command;
}

}  // namespace hpgo_cli
