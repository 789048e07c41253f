#include <cmath>
#include <cstdio>
#include <string>
#include <variant>
#include <vector>

#include "hpgo/evaluate/chi2.h"
#include "hpgo/evaluate/kitti_segments.h"
#include "hpgo/evaluate/trajectory_error.h"
#include "hpgo/io/output_file.h"
#include "nlohmann/json.hpp"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/pose_source.h"
#include "tools/read_graph.h"

DEFINE_string(edges, "", "the g2o file whose edges the poses are judged by; the estimate's own");
DEFINE_string(alignment, "rigid",
              "how the estimate is laid on the reference for the ATE: rigid (least squares), first "
              "(the first poses coincide) or none");
DEFINE_int32(rpe_delta, 1, "the number of poses that each motion of the RPE spans");
DEFINE_double(max_chi2, -1, "exit with code 6 if chi2 is larger; negative: any will do");
DEFINE_double(max_ate, -1, "exit with code 6 if the ATE's RMSE (m) is larger; negative: any");

namespace hpgo_cli {
namespace {

using hpgo::SE2;
using hpgo::SE3;
using nlohmann::ordered_json;

// A line of results; not in between those of --json=-.
void Line(const char* name, const std::string& text) {
  char padded[32];
  std::snprintf(padded, sizeof(padded), "%-6s", name);
  (FLAGS_json == "-" ? Message : Print)(padded + text);
}

template <typename G>
std::vector<G> PosesAs(const std::vector<SE3>& poses, const std::string& name,
                       hpgo::Status* status) {
  if constexpr (G::kDim == 3) {
    static_cast<void>(name);
    static_cast<void>(status);
    return poses;
  } else {
    hpgo::Result<std::vector<SE2>> planar = PlanarPoses(poses, name);
    *status = planar.status();
    return planar.ok() ? *std::move(planar) : std::vector<SE2>();
  }
}

// Gives the nodes of `graph` the poses of the estimate.
template <typename G>
hpgo::Status TakePoses(const PoseSource& estimate, PoseSource* edges, hpgo::PoseGraph<G>* graph) {
  hpgo::Status status;
  const std::vector<G> poses = PosesAs<G>(estimate.trajectory.poses, estimate.name, &status);
  if (!status.ok()) return status;
  const hpgo::Result<PoseMatches> matches = MatchPoses(*edges, estimate);
  if (!matches.ok()) return matches.status();
  std::vector<bool> matched(edges->trajectory.ids.size(), false);
  for (const auto& [node, pose] : matches->pairs) {
    matched[node] = true;
    graph->node(*graph->Find(edges->trajectory.ids[node])).pose = poses[pose];
  }
  for (std::size_t k = 0; k < matched.size(); ++k) {
    if (matched[k]) continue;
    return hpgo::Status(hpgo::StatusCode::kInvalidArgument,
                        "node " + std::to_string(edges->trajectory.ids[k]) + " of " + edges->name +
                            " has no pose in " + estimate.name);
  }
  return hpgo::Status::Ok();
}

template <typename G>
int EvaluateEdges(const hpgo::PoseGraph<G>& graph, ordered_json* json) {
  hpgo::Chi2Options options;
  options.convention = ConventionOfFlag();
  const hpgo::Chi2Report report = hpgo::EvaluateChi2(graph, options);
  Line("chi2", FormatNumber(report.total) + "  (sum of e' Omega e, " + FLAGS_error + " error; " +
                   Plural(graph.edges().size(), "edge") + " " + FormatNumber(report.edge_total) +
                   ", " + Plural(graph.priors().size(), "prior") + " " +
                   FormatNumber(report.prior_total) + ")");
  (*json)["error"] = FLAGS_error;
  (*json)["chi2"] = report.total;
  (*json)["edges"] = graph.edges().size();
  (*json)["edge_chi2"] = report.edge_total;
  (*json)["priors"] = graph.priors().size();
  (*json)["prior_chi2"] = report.prior_total;
  if (!std::isfinite(report.total)) {
    Error("chi2 is not finite");
    return kExitNoSolution;
  }
  if (FLAGS_max_chi2 >= 0 && !(report.total <= FLAGS_max_chi2)) {
    Error("chi2 " + FormatNumber(report.total) + " is above " + FormatNumber(FLAGS_max_chi2));
    return kExitComparison;
  }
  return kExitOk;
}

ordered_json StatisticsJson(const hpgo::ErrorStatistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"max", s.max}};
}
template <typename G>
void Report(const char* name, const char* key, const hpgo::TrajectoryError<G>& error,
            const std::string& what, ordered_json* json) {
  const auto text = [](const hpgo::ErrorStatistics& s) {
    return "rmse " + FormatNumber(s.rmse) + ", mean " + FormatNumber(s.mean) + ", max " +
           FormatNumber(s.max);
  };
  Line(name, text(error.translation) + " m; " + text(error.rotation) + " rad  (" + what + ")");
  (*json)[key] = {{"translation_m", StatisticsJson(error.translation)},
                  {"rotation_rad", StatisticsJson(error.rotation)}};
}

template <typename G>
int EvaluatePoses(const PoseSource& estimate, const PoseSource& reference, ordered_json* json) {
  const hpgo::Result<PoseMatches> matches = MatchPoses(estimate, reference);
  if (!matches.ok()) return Fail(matches.status());
  hpgo::Status status;
  const std::vector<G> all_estimated =
      PosesAs<G>(estimate.trajectory.poses, estimate.name, &status);
  if (!status.ok()) return Fail(status);
  const std::vector<G> all_true = PosesAs<G>(reference.trajectory.poses, reference.name, &status);
  if (!status.ok()) return Fail(status);
  std::vector<G> estimated, truth;
  for (const auto& [first, second] : matches->pairs) {
    estimated.push_back(all_estimated[first]);
    truth.push_back(all_true[second]);
  }
  Message(Plural(estimated.size(), "pose") + " matched by " + matches->by + ", of " +
          FormatCount(static_cast<std::int64_t>(all_estimated.size())) + " estimated and " +
          FormatCount(static_cast<std::int64_t>(all_true.size())) + " true, in " +
          std::to_string(G::kDim) + "D");
  (*json)["matched_poses"] = estimated.size();
  (*json)["matched_by"] = matches->by;

  const hpgo::AlignmentMode mode = FLAGS_alignment == "rigid"   ? hpgo::AlignmentMode::kRigid
                                   : FLAGS_alignment == "first" ? hpgo::AlignmentMode::kFirstPose
                                                                : hpgo::AlignmentMode::kIdentity;
  const auto ate = hpgo::AbsoluteTrajectoryError(estimated, truth, mode);
  if (!ate.ok()) return Fail(ate.status());
  (*json)["alignment"] = FLAGS_alignment;
  Report("ATE", "ate", *ate, "alignment: " + FLAGS_alignment, json);
  if (static_cast<std::size_t>(FLAGS_rpe_delta) < estimated.size()) {
    const auto rpe = hpgo::RelativeTrajectoryError(estimated, truth, FLAGS_rpe_delta);
    if (!rpe.ok()) return Fail(rpe.status());
    (*json)["rpe_delta"] = FLAGS_rpe_delta;
    Report("RPE", "rpe", *rpe, "over " + Plural(FLAGS_rpe_delta, "step"), json);
  } else {
    Message("no RPE: the trajectory is too short");
  }
  const auto kitti = hpgo::EvaluateKittiSegments(estimated, truth);
  if (!kitti.ok()) return Fail(kitti.status());
  if (kitti->segments > 0) {
    Line("KITTI", "translation " + FormatNumber(kitti->translation_ratio) + ", rotation " +
                      FormatNumber(kitti->rotation_rad_per_m) + " rad/m  (" +
                      Plural(kitti->segments, "segment") + " of 100 to 800 m)");
    (*json)["kitti"] = {{"translation_ratio", kitti->translation_ratio},
                        {"rotation_rad_per_m", kitti->rotation_rad_per_m},
                        {"segments", kitti->segments}};
  } else {
    Message("no KITTI segments: the reference is shorter than 100 m");
  }
  if (FLAGS_max_ate >= 0 && !(ate->translation.rmse <= FLAGS_max_ate)) {
    Error("ATE " + FormatNumber(ate->translation.rmse) + " m is above " +
          FormatNumber(FLAGS_max_ate) + " m");
    return kExitComparison;
  }
  return kExitOk;
}

// What is wrong with the flags; empty if nothing.
std::string FlagProblem(const std::vector<std::string>& arguments) {
  if (FLAGS_error != "g2o" && FLAGS_error != "log") {
    return "--error=" + FLAGS_error + ": must be g2o or log";
  }
  if (FLAGS_alignment != "rigid" && FLAGS_alignment != "first" && FLAGS_alignment != "none") {
    return "--alignment=" + FLAGS_alignment + ": must be rigid, first or none";
  }
  if (FLAGS_plane != "" && FLAGS_plane != "xy" && FLAGS_plane != "xz") {
    return "--plane=" + FLAGS_plane + ": must be xy or xz";
  }
  if (FLAGS_rpe_delta < 1) {
    return "--rpe_delta=" + std::to_string(FLAGS_rpe_delta) + ": must be above 0";
  }
  if ((arguments[0] == "-") + (FLAGS_edges == "-") + (FLAGS_reference == "-") > 1) {
    return "only one file can be the standard input";
  }
  if (FLAGS_max_ate >= 0 && FLAGS_reference.empty()) return "--max_ate needs --reference";
  return "";
}

int Evaluate(const PoseSource& estimate, ordered_json* json) {
  int exit_code = kExitOk;
  hpgo::Result<PoseSource> edges = estimate;
  if (!FLAGS_edges.empty()) {
    edges = ReadPoseSource(FLAGS_edges);
    if (!edges.ok()) return Fail(edges.status());
    if (!edges->graph.has_value()) {
      return FailUsage("--edges=" + FLAGS_edges + ": not a g2o or TORO file");
    }
  }
  const bool planar = edges->graph.has_value() && edges->graph->index() == 0;
  if (edges->graph.has_value()) {
    exit_code = std::visit(
        [&](auto& file) -> int {
          if (!FLAGS_edges.empty()) {
            const hpgo::Status status = TakePoses(estimate, &*edges, &file.graph);
            if (!status.ok()) return Fail(status);
          }
          if (file.graph.edges().empty() && file.graph.priors().empty()) {
            Message("no edges: no chi2");
            return FLAGS_max_chi2 >= 0 ? FailUsage("--max_chi2 needs edges") : int{kExitOk};
          }
          return EvaluateEdges(file.graph, json);
        },
        *edges->graph);
  } else if (FLAGS_reference.empty() || FLAGS_max_chi2 >= 0) {
    return FailUsage(estimate.name + " has no edges: give --edges" +
                     (FLAGS_reference.empty() ? " or --reference" : ""));
  }
  if (FLAGS_reference.empty() || (exit_code != kExitOk && exit_code != kExitComparison)) {
    return exit_code;
  }
  const hpgo::Result<PoseSource> reference = ReadPoseSource(FLAGS_reference);
  if (!reference.ok()) return Fail(reference.status());
  const int poses_exit = planar || !FLAGS_plane.empty()
                             ? EvaluatePoses<SE2>(estimate, *reference, json)
                             : EvaluatePoses<SE3>(estimate, *reference, json);
  return poses_exit != kExitOk ? poses_exit : exit_code;
}

int Run(const std::vector<std::string>& arguments) {
  const std::string problem = FlagProblem(arguments);
  if (!problem.empty()) return FailUsage(problem);
  const hpgo::Result<PoseSource> estimate = ReadPoseSource(arguments[0]);
  if (!estimate.ok()) return Fail(estimate.status());
  ordered_json json = {{"estimate", arguments[0]}, {"poses", estimate->trajectory.poses.size()}};
  const int exit_code = Evaluate(*estimate, &json);
  if (exit_code != kExitOk && exit_code != kExitComparison && exit_code != kExitNoSolution) {
    return exit_code;
  }
  json["exit_code"] = exit_code;
  if (FLAGS_json.empty()) return exit_code;
  const hpgo::Status written = hpgo::WriteTextFile(FLAGS_json, json.dump(2) + "\n");
  return written.ok() ? exit_code : Fail(written);
}

}  // namespace

const Command& EvaluateCommand() {
  static const Command* command = new Command{
      "evaluate",
      "ESTIMATE",
      "Judges poses by edges (chi2) and by a reference (ATE, RPE, KITTI segments).",
      1,
      1,
      {"edges", "reference", "plane", "by_order", "alignment", "rpe_delta", "error", "json",
       "max_chi2", "max_ate", "strict", "project_information", "identity_information",
       "create_missing", "row_major_edge2"},
      &Run,
      "ESTIMATE is a g2o, TORO, KITTI or TUM file; a graph without vertices is judged at its dead "
      "reckoning.\n"
      "Poses of two files are matched by id, time or line. ATE: positions after alignment; RPE: "
      "motions\nover --rpe_delta poses; KITTI: the mean error over segments of 100 to 800 m, as a "
      "ratio and in rad/m.\n\n"
      "Examples:\n"
      "  hpgo evaluate optimized.g2o --reference=truth.tum\n"
      "  hpgo evaluate poses.txt --edges=map.g2o\n"
      "  hpgo evaluate kitti_00.g2o --reference=00.txt --plane=xz --json=figures.json\n"};
  return *command;
}

}  // namespace hpgo_cli
