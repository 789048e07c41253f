#include "tools/pose_source.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <variant>

#include "hpgo/evaluate/ground_plane.h"
#include "hpgo/graph/compose_poses.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/input_text.h"
#include "hpgo/io/line_fields.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/read_graph.h"

namespace hpgo_cli {
namespace {

using hpgo::SE2;
using hpgo::SE3;
using hpgo::Status;
using hpgo::StatusCode;
using hpgo::Trajectory;

constexpr double kStampTolerance = 0.01;  // s, as evo's

bool LiesInXyPlane(const std::vector<SE3>& poses) {
  return std::all_of(poses.begin(), poses.end(), [](const SE3& pose) {
    return pose.translation().z() == 0 && pose.rotation().x() == 0 && pose.rotation().y() == 0;
  });
}

// What tells the poses of a trajectory apart.
const char* KeyName(const Trajectory& trajectory) {
  if (!trajectory.ids.empty()) return "id";
  return trajectory.stamps.empty() ? "line" : "time";
}

// ", 1000 to 1002", where there are stamps.
std::string StampRange(const Trajectory& trajectory) {
  if (trajectory.stamps.empty()) return "";
  const auto [first, last] =
      std::minmax_element(trajectory.stamps.begin(), trajectory.stamps.end());
  std::string text = ", ";
  hpgo::AppendNumber(*first, &text);
  text += " to ";
  hpgo::AppendNumber(*last, &text);
  return text;
}

std::vector<std::pair<double, int>> SortedKeys(const Trajectory& trajectory) {
  std::vector<std::pair<double, int>> keys;
  for (int k = 0; k < static_cast<int>(trajectory.poses.size()); ++k) {
    const double key = !trajectory.ids.empty()      ? static_cast<double>(trajectory.ids[k])
                       : !trajectory.stamps.empty() ? trajectory.stamps[k]
                                                    : static_cast<double>(k);
    keys.emplace_back(key, k);
  }
  std::sort(keys.begin(), keys.end());
  return keys;
}

std::vector<std::pair<int, int>> MatchById(const Trajectory& first, const Trajectory& second) {
  std::unordered_map<hpgo::NodeId, int> index;
  for (int k = 0; k < static_cast<int>(second.ids.size()); ++k) index.emplace(second.ids[k], k);
  std::vector<std::pair<int, int>> pairs;
  for (int k = 0; k < static_cast<int>(first.ids.size()); ++k) {
    const auto found = index.find(first.ids[k]);
    if (found != index.end()) pairs.emplace_back(k, found->second);
  }
  return pairs;
}

std::vector<std::pair<int, int>> MatchByKey(const Trajectory& first, const Trajectory& second) {
  const std::vector<std::pair<double, int>> keys = SortedKeys(second);
  std::vector<std::pair<int, int>> pairs;
  for (const auto& [key, k] : SortedKeys(first)) {
    auto nearest = std::lower_bound(keys.begin(), keys.end(), std::make_pair(key, 0));
    if (nearest == keys.end() ||
        (nearest != keys.begin() && key - std::prev(nearest)->first < nearest->first - key)) {
      if (nearest == keys.begin()) break;
      --nearest;
    }
    if (std::abs(nearest->first - key) <= kStampTolerance) pairs.emplace_back(k, nearest->second);
  }
  return pairs;
}

}  // namespace

hpgo::Result<PoseSource> ReadPoseSource(const std::string& path) {
  const hpgo::Result<hpgo::InputText> input = hpgo::InputText::Read(path);
  if (!input.ok()) return input.status();
  PoseSource source;
  source.name = input->name();
  hpgo::ReadReport report;
  const hpgo::TrajectoryFormat format = hpgo::DetectFormat(input->text());
  Status status;
  if (format == hpgo::TrajectoryFormat::kKitti || format == hpgo::TrajectoryFormat::kTum) {
    auto trajectory = hpgo::ParseTrajectory(input->text(), input->name(), format,
                                            ReadOptionsFromFlags(), &report);
    if (trajectory.ok()) source.trajectory = *std::move(trajectory);
    status = trajectory.status();
  } else {
    auto graph = hpgo::ParseG2o(input->text(), input->name(), ReadOptionsFromFlags(), &report);
    if (graph.ok()) source.graph = *std::move(graph);
    status = graph.status();
  }
  for (const std::string& warning : report.warnings) Warn(warning);
  if (!status.ok()) return status;
  if (source.graph.has_value()) {
    std::visit(
        [&source](auto& file) {
          if (hpgo::ComposeMissingPoses(&file.graph) > 0) {
            Message(source.name + " has no vertices: poses are composed from the edges");
          }
          source.trajectory = hpgo::ToTrajectory(file.graph);
        },
        *source.graph);
  }
  return source;
}

hpgo::Result<std::vector<SE2>> PlanarPoses(const std::vector<SE3>& poses, const std::string& name) {
  if (FLAGS_plane != "" && FLAGS_plane != "xy" && FLAGS_plane != "xz") {
    return Status(StatusCode::kInvalidArgument, "--plane=" + FLAGS_plane + ": must be xy or xz");
  }
  const bool lies_in_plane = LiesInXyPlane(poses);
  if (FLAGS_plane.empty() && !lies_in_plane) {
    return Status(StatusCode::kInvalidArgument,
                  name +
                      " is 3D: seen in 2D it needs --plane=xy (z up) or --plane=xz (a camera's "
                      "frame, as KITTI's)");
  }
  return hpgo::ProjectToPlane(poses, FLAGS_plane == "xz" && !lies_in_plane
                                         ? hpgo::GroundPlane::kXz
                                         : hpgo::GroundPlane::kXy);
}

hpgo::Result<PoseMatches> MatchPoses(const PoseSource& first, const PoseSource& second) {
  const Trajectory &a = first.trajectory, &b = second.trajectory;
  PoseMatches matches;
  if (!a.ids.empty() && !b.ids.empty()) {
    matches.pairs = MatchById(a, b);
    matches.by = "id";
    if (!matches.pairs.empty()) return matches;
    return Status(StatusCode::kInvalidArgument,
                  "no node of " + first.name + " is in " + second.name);
  }
  matches.pairs = MatchByKey(a, b);
  const bool with_ids = !a.ids.empty() || !b.ids.empty();
  const std::string key_a = KeyName(a), key_b = KeyName(b);
  matches.by = with_ids ? "id" : key_a;
  // Ids or line numbers agree with the stamps of a clock by chance at most.
  const bool chance = key_a != key_b && (key_a == "time" || key_b == "time");
  if (chance && matches.pairs.size() < std::min(a.poses.size(), b.poses.size())) {
    matches.pairs.clear();
  }
  // Two clocks can be compared: where no time agrees, the files hardly belong together.
  const bool clocks = key_a == "time" && key_b == "time";
  const bool same_size = a.poses.size() == b.poses.size();
  if (matches.pairs.empty() && same_size && (FLAGS_by_order || !clocks)) {
    for (int k = 0; k < static_cast<int>(a.poses.size()); ++k) matches.pairs.emplace_back(k, k);
    matches.by = "order";
  }
  if (!matches.pairs.empty()) return matches;
  std::string hint;
  if (clocks && same_size) {
    hint = "; --by_order matches them one by one";
  } else if (FLAGS_by_order) {
    hint = "; --by_order needs as many poses in both, not " + std::to_string(a.poses.size()) +
           " and " + std::to_string(b.poses.size());
  }
  return Status(StatusCode::kInvalidArgument, "no pose of " + first.name + " (by " + key_a +
                                                  StampRange(a) + ") belongs to one of " +
                                                  second.name + " (by " + key_b + StampRange(b) +
                                                  ")" + hint);
}

}  // namespace hpgo_cli
