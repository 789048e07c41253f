#include <algorithm>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "gflags/gflags.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/output_file.h"
#include "hpgo/io/trajectory.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/console.h"
#include "tools/read_graph.h"

DEFINE_string(from, "auto", "the input's format: auto (by content), g2o (and TORO), kitti or tum");
DEFINE_string(to, "auto",
              "the output's format: auto (by the extension .g2o, .kitti, .txt or .tum; .txt is "
              "KITTI's), g2o, kitti or tum");

namespace hpgo_cli {
namespace {

using hpgo::TrajectoryFormat;

std::optional<TrajectoryFormat> ParseFormat(const std::string& name) {
  if (name == "auto") return TrajectoryFormat::kAuto;
  if (name == "g2o" || name == "toro") return TrajectoryFormat::kG2o;
  if (name == "kitti") return TrajectoryFormat::kKitti;
  if (name == "tum") return TrajectoryFormat::kTum;
  return std::nullopt;
}

TrajectoryFormat FormatOfExtension(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::size_t dot = path.rfind('.');
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) {
    return TrajectoryFormat::kAuto;
  }
  const std::string extension = path.substr(dot);
  if (extension == ".g2o") return TrajectoryFormat::kG2o;
  if (extension == ".kitti" || extension == ".txt") return TrajectoryFormat::kKitti;
  return extension == ".tum" ? TrajectoryFormat::kTum : TrajectoryFormat::kAuto;
}

std::string FormatName(TrajectoryFormat format) {
  return format == TrajectoryFormat::kKitti ? "KITTI" : "TUM";
}

hpgo::Status WriteAs(const hpgo::Trajectory& trajectory, TrajectoryFormat format,
                     const std::string& path) {
  if (format != TrajectoryFormat::kTum && !trajectory.stamps.empty()) {
    Warn("the time stamps are left out: the output has no place for them");
  }
  if (format == TrajectoryFormat::kTum && trajectory.stamps.empty()) {
    Message("the numbers from zero stand in for the time stamps");
  }
  if (format != TrajectoryFormat::kG2o) return WriteTrajectory(trajectory, format, path);
  hpgo::PoseGraph3d graph;
  for (const hpgo::SE3& pose : trajectory.poses) {
    hpgo::GraphNode<hpgo::SE3> node;
    node.id = static_cast<hpgo::NodeId>(graph.nodes().size());
    node.pose = pose;
    const hpgo::Result<int> added = graph.AddNode(node);
    if (!added.ok()) return added.status();
  }
  return WriteG2o(graph, path);
}

template <typename G>
hpgo::Status WriteAs(const hpgo::GraphFile<G>& file, TrajectoryFormat format,
                     const std::string& path) {
  if (format == TrajectoryFormat::kG2o) return WriteG2o(file, path);
  const std::size_t edges = file.graph.edges().size(), priors = file.graph.priors().size();
  if (edges + priors + file.fix.size() + file.verbatim.size() > 0) {
    Warn(FormatName(format) +
         " holds poses alone; left out: " + Plural(static_cast<std::int64_t>(edges), "edge") +
         ", " + Plural(static_cast<std::int64_t>(priors), "prior") + ", " +
         Plural(static_cast<std::int64_t>(file.fix.size()), "FIX line") + ", " +
         Plural(static_cast<std::int64_t>(file.verbatim.size()), "other line"));
  }
  const auto& nodes = file.graph.nodes();
  if (!std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.has_pose; })) {
    Message("no vertices: poses are composed from the edges");
  }
  if (format == TrajectoryFormat::kTum) Message("the node ids stand in for the time stamps");
  return WriteTrajectory(ToTrajectory(file.graph), format, path);
}

int Run(const std::vector<std::string>& arguments) {
  const std::string& output = arguments[1];
  std::optional<TrajectoryFormat> from = ParseFormat(FLAGS_from), to = ParseFormat(FLAGS_to);
  if (!from) return FailUsage("--from=" + FLAGS_from + ": must be auto, g2o, kitti or tum");
  if (!to || FLAGS_to == "toro") {
    return FailUsage("--to=" + FLAGS_to + ": must be auto, g2o, kitti or tum");
  }
  if (*to == TrajectoryFormat::kAuto) to = FormatOfExtension(output);
  if (*to == TrajectoryFormat::kAuto) {
    return FailUsage("the name " + output +
                     " does not tell the format; say --to=g2o, kitti or tum");
  }
  const hpgo::Status writable = hpgo::CheckOutputPath(output);
  if (!writable.ok()) return Fail(writable);
  const hpgo::Result<hpgo::InputText> input = hpgo::InputText::Read(arguments[0]);
  if (!input.ok()) return Fail(input.status());
  if (*from == TrajectoryFormat::kAuto) from = hpgo::DetectFormat(input->text());

  hpgo::ReadReport report;
  hpgo::Status written;
  const auto write = [&](const auto& content) {
    for (const std::string& warning : report.warnings) Warn(warning);
    written = WriteAs(content, *to, output);
  };
  const hpgo::ReadOptions options = ReadOptionsFromFlags();
  if (*from == TrajectoryFormat::kG2o) {
    const auto file = hpgo::ParseG2o(input->text(), input->name(), options, &report);
    if (!file.ok()) return Fail(file.status());
    std::visit(write, *file);
  } else {
    const auto read = hpgo::ParseTrajectory(input->text(), input->name(), *from, options, &report);
    if (!read.ok()) return Fail(read.status());
    write(*read);
  }
  if (!written.ok()) return Fail(written);
  if (output != "-") Message("wrote " + output);
  return kExitOk;
}

}  // namespace

const Command& ConvertCommand() {
  static const Command* command = new Command{
      "convert",
      "INPUT OUTPUT",
      "Writes a graph or a trajectory in another format: g2o, KITTI or TUM.",
      2,
      2,
      {"from", "to", "strict", "project_information", "identity_information", "create_missing",
       "row_major_edge2"},
      &Run,
      "Reads g2o, TORO, KITTI and TUM. From g2o to g2o everything is kept, unknown lines too;\n"
      "TORO becomes g2o. KITTI and TUM take the poses alone, in the order of the node ids, with\n"
      "z = 0 for a 2D graph; poses that the file does not give are composed from its edges.\n"
      "- is the standard input or output.\n"
      "\n"
      "  hpgo convert map.graph map.g2o\n"
      "  hpgo convert map.g2o poses.tum\n"
      "  hpgo convert --to=kitti - - < map.g2o > poses.txt\n"};
  return *command;
}

}  // namespace hpgo_cli
