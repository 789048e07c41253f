#include "tools/replay_flags.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "ceres_costs/losses.h"
#include "glog/logging.h"
#include "hpgo/solve/solver_factory.h"
#include "hpgo/state/state_writer.h"
#include "tools/common_flags.h"

namespace {
// Defaults stand in the settings alone.
const hpgo_cli::ReplaySettings kDefaults;
}  // namespace

DEFINE_string(solve_every, "1",
              "an update at every so many nodes, or at each node with a loop closure: 'loop'");
DEFINE_string(update_at, "nodes",
              "an update after as many nodes as --solve_every says: 'nodes', or when a loop "
              "closure arrives, and at the last node: 'closures', as --solve_every=loop");
DEFINE_int32(stale_poses, kDefaults.stale_poses,
             "a client that reads the poses once in so many updates: new nodes start in those it "
             "has; 0: in the current estimate");
DEFINE_string(mode, "partial",
              "what an update solves: partial (windows on every level), top (the top level only) "
              "or full (the whole graph)");
DEFINE_string(preset, "accurate", "accurate, fast, eager or paper");
DEFINE_int32(window_nodes, 0, "free poses of a window; 0: the preset's");
DEFINE_int32(max_windows, 0, "windows an update; 0: the preset's");
DEFINE_double(stress_threshold, -1,
              "a window is opened for a decrease of chi2 above this share of an edge's mean; "
              "negative: the preset's");
DEFINE_double(update_seconds, kDefaults.update_seconds,
              "the time an update may take, instead of --max_windows; 0: no such limit");
DEFINE_string(stats_csv, "", "write a line an update to this file; - is the standard output");
DEFINE_int32(chi2_every, kDefaults.chi2_every,
             "updates between two values of chi2 in --stats_csv; 0: none");
DEFINE_string(summary_csv, "", "add a line with the summary's figures to this table");
DEFINE_string(compare_full, "",
              "the percentages of the replay, as in 25,50,75,100, at which the gap to the full "
              "optimum of the graph so far is found");
DEFINE_string(compare_at, "",
              "'closures' or 'closures:N': the gap right after the updates that take in a loop "
              "closure, of N of them at most, evenly spread; N is 40 if not given");
DEFINE_string(chart, "", "draw the gaps of --compare_at over the nodes, as SVG, to this file");
DEFINE_double(compare_threshold, -1,
              "exit with code 6 if a gap is larger, in percent; negative: any will do");
DEFINE_double(stats_from, kDefaults.stats_from,
              "the latencies are of the updates after this share of the nodes, 0 to below 1");
DEFINE_string(measure_mode, "",
              "make the last updates in this mode, and give the latencies of them alone");
DEFINE_int32(measure_updates, kDefaults.measure_updates, "how many those are");
DEFINE_bool(refine, false,
            "after the last update, work on until nothing is stressed; the gap before and after");
DEFINE_string(save, "",
              "save the optimizer's whole state to this file, at the end or where the replay is "
              "interrupted");
DEFINE_int32(save_every, kDefaults.save_every, "save it after so many nodes, too; 0: only then");
DEFINE_string(resume, "",
              "go on from a state that --save has written while it replayed the same graph: the "
              "result is that of an uninterrupted replay, bit for bit");
DEFINE_double(
    far_closure, kDefaults.far_closure,
    "at the end, add a loop closure that is off by so much that its chi2 is so many times "
    "an edge's mean, and show the gap over 100 more updates; 0: none");

namespace hpgo_cli {
namespace {

std::optional<hpgo::Mode> ParseMode(const std::string& name) {
  if (name == "partial") return hpgo::Mode::kPartial;
  if (name == "top") return hpgo::Mode::kTop;
  if (name == "full") return hpgo::Mode::kFull;
  return std::nullopt;
}

std::string FlagText(const std::string& name) {
  std::string value;
  gflags::GetCommandLineOption(name.c_str(), &value);
  return "--" + name + "=" + value + ": ";
}

// "25,50,75,100", ascending, without repetitions; empty on a wrong value.
std::vector<double> ParsePercentages(const std::string& text) {
  std::vector<double> percentages;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    const std::string item = text.substr(begin, comma - begin);
    char* end = nullptr;
    const double value = std::strtod(item.c_str(), &end);
    if (item.empty() || *end != '\0' || !(value > 0 && value <= 100)) return {};
    percentages.push_back(value);
    begin = comma + 1;
  }
  std::sort(percentages.begin(), percentages.end());
  percentages.erase(std::unique(percentages.begin(), percentages.end()), percentages.end());
  return percentages;
}

// How many closing updates to compare after: "closures" or "closures:N"; 0 on a wrong value.
int ParseClosures(const std::string& text) {
  constexpr int kSampled = 40;
  const std::string name = "closures";
  if (text == name) return kSampled;
  if (text.compare(0, name.size() + 1, name + ":") != 0) return 0;
  const std::string digits = text.substr(name.size() + 1);
  char* end = nullptr;
  const std::int64_t value = std::strtol(digits.c_str(), &end, 10);
  const bool valid =
      !digits.empty() && *end == '\0' && value >= 1 && value <= std::numeric_limits<int>::max();
  return valid ? static_cast<int>(value) : 0;
}

// The preset with what the flags override; what is wrong with them goes to `problem`.
hpgo::OptimizerOptions OptionsFromFlags(std::string* problem) {
  const hpgo::Result<hpgo::OptimizerOptions> preset =
      hpgo::OptimizerOptions::FromName(FLAGS_preset);
  if (!preset.ok()) {
    *problem = FlagText("preset") + "must be accurate, fast, eager or paper";
    return {};
  }
  hpgo::OptimizerOptions options = *preset;
  if (const auto mode = ParseMode(FLAGS_mode); mode.has_value()) {
    options.mode = *mode;
  } else {
    *problem = FlagText("mode") + "must be partial, top or full";
  }
  if (const auto engine = hpgo::ParseEngine(FLAGS_engine); engine.has_value()) {
    options.engine = *engine;
  } else {
    *problem = FlagText("engine") + "must be ceres or block";
  }
  options.convention = ConventionOfFlag();
  if (FLAGS_error != "g2o" && FLAGS_error != "log") {
    *problem = FlagText("error") + "must be g2o or log";
  }
  if (FLAGS_window_nodes != 0) options.window_nodes = FLAGS_window_nodes;
  if (FLAGS_max_top_nodes != 0) options.max_top_nodes = FLAGS_max_top_nodes;
  if (FLAGS_max_top_edges != 0) options.max_top_edges = FLAGS_max_top_edges;
  if (FLAGS_max_windows != 0) options.max_windows = FLAGS_max_windows;
  if (FLAGS_stress_threshold >= 0) options.stress_threshold = FLAGS_stress_threshold;
  const hpgo::Status status = options.Validate();
  if (problem->empty() && !status.ok()) *problem = "--" + status.message();
  return options;
}

// What is saved of the options.
std::string Bytes(const hpgo::OptimizerOptions& options) {
  std::string bytes;
  hpgo::StateWriter writer([&](const char*, std::string_view block) { bytes += block; });
  writer.Section("options");
  writer(options);
  CHECK(writer.Finish().ok());
  return bytes;
}

}  // namespace

std::string ConflictWithSaved(const hpgo::OptimizerOptions& saved,
                              const hpgo::OptimizerOptions& wanted) {
  if (Bytes(saved) == Bytes(wanted)) return "";
  for (const char* name : {"mode", "preset", "engine", "error", "window_nodes", "max_top_nodes",
                           "max_top_edges", "max_windows", "stress_threshold"}) {
    if (gflags::GetCommandLineFlagInfoOrDie(name).is_default) continue;
    return FlagText(name) + "the options of the state are others";
  }
  return "";
}

ReplaySettings ReplaySettingsFromFlags(std::string* problem) {
  ReplaySettings settings;
  settings.options = OptionsFromFlags(problem);
  if (!problem->empty()) return settings;
  settings.update_seconds = FLAGS_update_seconds;
  settings.loss = {FLAGS_loss, FLAGS_loss_scale};
  settings.stats_from = FLAGS_stats_from;
  settings.measure_mode = ParseMode(FLAGS_measure_mode);
  settings.measure_updates = FLAGS_measure_updates;
  settings.stale_poses = FLAGS_stale_poses;
  settings.stats_csv = FLAGS_stats_csv;
  settings.chi2_every = FLAGS_chi2_every;
  settings.refine = FLAGS_refine;
  settings.far_closure = FLAGS_far_closure;
  settings.save = FLAGS_save;
  settings.save_every = FLAGS_save_every;
  char* end = nullptr;
  settings.solve_every = FLAGS_solve_every == "loop"
                             ? 0
                             : static_cast<int>(std::strtol(FLAGS_solve_every.c_str(), &end, 10));
  std::unique_ptr<ceres::LossFunction> loss;
  std::string error;
  if (FLAGS_solve_every != "loop" && (*end != '\0' || settings.solve_every < 1)) {
    *problem = FlagText("solve_every") + "must be a number above 0, or loop";
  } else if (FLAGS_update_at != "nodes" && FLAGS_update_at != "closures") {
    *problem = FlagText("update_at") + "must be nodes or closures";
  } else if (FLAGS_update_at == "closures" && settings.solve_every > 1) {
    *problem = FlagText("solve_every") + "does not go with --update_at=closures";
  } else if (FLAGS_stale_poses < 0) {
    *problem = FlagText("stale_poses") + "must not be negative";
  } else if (!(FLAGS_update_seconds >= 0)) {
    *problem = FlagText("update_seconds") + "must not be negative";
  } else if (!ceres_costs::MakeLoss(FLAGS_loss, FLAGS_loss_scale, &loss, &error)) {
    *problem = "--loss: " + error;
  } else if (!(FLAGS_stats_from >= 0 && FLAGS_stats_from < 1)) {
    *problem = FlagText("stats_from") + "must be from 0 to below 1";
  } else if (!FLAGS_measure_mode.empty() && !settings.measure_mode.has_value()) {
    *problem = FlagText("measure_mode") + "must be partial, top or full";
  } else if (FLAGS_measure_updates < 1) {
    *problem = FlagText("measure_updates") + "must be above 0";
  } else if (!(FLAGS_far_closure >= 0 && std::isfinite(FLAGS_far_closure))) {
    *problem = FlagText("far_closure") + "must be a number from 0 on";
  } else if (FLAGS_chi2_every < 0) {
    *problem = FlagText("chi2_every") + "must not be negative";
  } else if ((FLAGS_output == "-") + (FLAGS_stats_csv == "-") + (FLAGS_stats_json == "-") +
                 (FLAGS_chart == "-") >
             1) {
    *problem =
        "only one of --output, --stats_csv, --stats_json and --chart can be the standard output";
  } else if (FLAGS_save == "-") {
    *problem = "--save=-: must be a file";
  } else if (FLAGS_save_every < 0) {
    *problem = FlagText("save_every") + "must not be negative";
  } else if (FLAGS_save_every > 0 && FLAGS_save.empty()) {
    *problem = "--save_every needs --save";
  } else if (!FLAGS_resume.empty() && FLAGS_stale_poses > 0) {
    *problem = "--stale_poses does not go with --resume: the client's poses are not in the state";
  } else if (!FLAGS_resume.empty() && !FLAGS_compare_at.empty()) {
    *problem = "--compare_at does not go with --resume: closures before it are missed";
  } else if (FLAGS_summary_csv == "-") {
    *problem = "--summary_csv=-: must be a file";
  }
  if (!FLAGS_compare_full.empty()) {
    settings.compare_at = ParsePercentages(FLAGS_compare_full);
    if (settings.compare_at.empty()) {
      *problem = FlagText("compare_full") + "must be percentages above 0, as in 25,50,75,100";
    }
  }
  if (FLAGS_update_at == "closures") settings.solve_every = 0;
  if (!FLAGS_compare_at.empty()) {
    settings.compare_closures = ParseClosures(FLAGS_compare_at);
    if (settings.compare_closures == 0) {
      *problem = FlagText("compare_at") + "must be closures, or closures:N with N above 0";
    }
  } else if (!FLAGS_chart.empty()) {
    *problem = "--chart needs --compare_at";
  }
  if (FLAGS_refine && (settings.compare_at.empty() || settings.compare_at.back() < 100)) {
    settings.compare_at.push_back(100);
  }
  if (FLAGS_compare_threshold >= 0 && settings.compare_at.empty() &&
      settings.compare_closures == 0) {
    *problem = "--compare_threshold needs --compare_full or --compare_at";
  }
  return settings;
}

}  // namespace hpgo_cli
