#include <chrono>
#include <string>
#include <vector>

#include "hpgo/generate/synthetic_graph.h"
#include "hpgo/io/g2o_writer.h"
#include "hpgo/io/trajectory.h"
#include "tools/command.h"
#include "tools/commands.h"
#include "tools/common_flags.h"
#include "tools/console.h"
#include "tools/pose_source.h"

namespace {
// A default of the generator stands in its options alone.
const hpgo::GenerateOptions kDefaults;
}  // namespace

DEFINE_string(
    world, hpgo::WorldName(kDefaults.world),
    "sphere, torus, grid, manhattan (dense loops, several floors), city (long streets) or "
    "trajectory (see --trajectory)");
DEFINE_int32(nodes, 0,
             "the number of poses, a metre apart; 0: 1000, or all those of the trajectory");
DEFINE_int32(dim, 3, "2 or 3");
DEFINE_double(noise_translation, kDefaults.noise_translation,
              "the standard deviation of each measurement per axis, in m");
DEFINE_double(noise_rotation, kDefaults.noise_rotation, "likewise of the rotation, in rad");
DEFINE_double(closure_density, kDefaults.closure_density,
              "loop closures per node, as far as the path allows; negative: the world's own");
DEFINE_double(outliers, kDefaults.outliers,
              "the share of the loop closures that are wrong, 0 to 1");
DEFINE_bool(dense_information, kDefaults.dense_information,
            "correlated noise: dense information matrices, another one for each edge");
DEFINE_string(trajectory, "",
              "for --world=trajectory: the KITTI, TUM or g2o file with the poses to follow");
DEFINE_string(ground_truth, "",
              "write the true poses to this file: TUM for .tum, KITTI for .txt, g2o otherwise");

namespace hpgo_cli {
namespace {

using hpgo::SE2;
using hpgo::SE3;

bool EndsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

template <typename G>
hpgo::Status WriteTruth(const hpgo::SyntheticGraph<G>& synthetic, const std::string& path) {
  const hpgo::PoseGraph<G> truth = hpgo::TruthGraph(synthetic);
  if (EndsWith(path, ".tum")) {
    return hpgo::WriteTrajectory(hpgo::ToTrajectory(truth), hpgo::TrajectoryFormat::kTum, path);
  }
  if (EndsWith(path, ".txt")) {
    return hpgo::WriteTrajectory(hpgo::ToTrajectory(truth), hpgo::TrajectoryFormat::kKitti, path);
  }
  return hpgo::WriteG2o(truth, path);
}

hpgo::Result<std::vector<SE3>> Follow(const PoseSource& source, const SE3*) {
  return source.trajectory.poses;
}
hpgo::Result<std::vector<SE2>> Follow(const PoseSource& source, const SE2*) {
  return PlanarPoses(source.trajectory.poses, source.name);
}

template <typename G>
hpgo::Result<hpgo::SyntheticGraph<G>> GenerateAlongFile(const hpgo::GenerateOptions& options) {
  const hpgo::Result<PoseSource> source = ReadPoseSource(FLAGS_trajectory);
  if (!source.ok()) return source.status();
  hpgo::Result<std::vector<G>> poses = Follow(*source, static_cast<const G*>(nullptr));
  if (!poses.ok()) return poses.status();
  if (static_cast<std::size_t>(FLAGS_nodes) > poses->size()) {
    return hpgo::Status(hpgo::StatusCode::kInvalidArgument,
                        "--nodes=" + std::to_string(FLAGS_nodes) + ": " + source->name +
                            " has only " + Plural(poses->size(), "pose"));
  }
  if (FLAGS_nodes > 0) poses->resize(FLAGS_nodes);
  return hpgo::GenerateAlong(*poses, options);
}

template <typename G>
int Generate(const hpgo::GenerateOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const auto synthetic = options.world == hpgo::World::kTrajectory
                             ? GenerateAlongFile<G>(options)
                             : hpgo::GenerateGraph<G>(options);
  if (!synthetic.ok()) {
    return synthetic.status().code() == hpgo::StatusCode::kInvalidArgument
               ? FailUsage(synthetic.status().message())
               : Fail(synthetic.status());
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  const std::size_t nodes = synthetic->graph.nodes().size();
  const std::size_t edges = synthetic->graph.edges().size();
  Message(std::string(hpgo::WorldName(options.world)) + " " + std::to_string(G::kDim) +
          "D: " + Plural(nodes, "node") + ", " + Plural(edges, "edge") + " (" +
          FormatNumber(static_cast<double>(edges) / static_cast<double>(nodes)) + " a node), " +
          Plural(synthetic->closures, "loop closure") + ", " +
          FormatCount(static_cast<std::int64_t>(synthetic->outlier_edges.size())) +
          " of them wrong, in " + FormatDuration(seconds.count()));

  hpgo::Status status = hpgo::WriteG2o(synthetic->graph, FLAGS_output);
  if (status.ok() && !FLAGS_ground_truth.empty()) {
    status = WriteTruth(*synthetic, FLAGS_ground_truth);
  }
  return status.ok() ? int{kExitOk} : Fail(status);
}

int Run(const std::vector<std::string>&) {
  const hpgo::Result<hpgo::World> world = hpgo::ParseWorld(FLAGS_world);
  if (!world.ok()) return FailUsage("--world: " + world.status().message());
  if (FLAGS_dim != 2 && FLAGS_dim != 3) {
    return FailUsage("--dim=" + std::to_string(FLAGS_dim) + ": must be 2 or 3");
  }
  if (FLAGS_nodes < 0) {
    return FailUsage("--nodes=" + std::to_string(FLAGS_nodes) + ": must not be negative");
  }
  if ((*world == hpgo::World::kTrajectory) != !FLAGS_trajectory.empty()) {
    return FailUsage("--world=trajectory and --trajectory=FILE belong together");
  }
  if (FLAGS_plane != "" && FLAGS_plane != "xy" && FLAGS_plane != "xz") {
    return FailUsage("--plane=" + FLAGS_plane + ": must be xy or xz");
  }
  if (FLAGS_output.empty()) return FailUsage("--output=FILE says where to write the graph");
  if (FLAGS_output == FLAGS_ground_truth) {
    return FailUsage("--output and --ground_truth cannot be the same file");
  }
  hpgo::GenerateOptions options;
  options.world = *world;
  if (FLAGS_nodes > 0) options.nodes = FLAGS_nodes;
  options.seed = FLAGS_seed;
  options.noise_translation = FLAGS_noise_translation;
  options.noise_rotation = FLAGS_noise_rotation;
  options.closure_density = FLAGS_closure_density;
  options.outliers = FLAGS_outliers;
  options.dense_information = FLAGS_dense_information;
  return FLAGS_dim == 2 ? Generate<SE2>(options) : Generate<SE3>(options);
}

}  // namespace

const Command& GenerateCommand() {
  static const Command* command = new Command{
      "generate",
      "",
      "Makes a synthetic pose graph, the same for the same seed, with the truth behind it.",
      0,
      0,
      {"world", "nodes", "dim", "seed", "noise_translation", "noise_rotation", "closure_density",
       "outliers", "dense_information", "trajectory", "plane", "strict", "project_information",
       "identity_information", "create_missing", "row_major_edge2", "output", "ground_truth"},
      &Run,
      "A robot drives through the world; its odometry and loop closures are measured with noise. "
      "The vertices\nhold dead reckoning. Information matrices are those of the noise in the error "
      "of g2o files.\n\n"
      "Examples:\n"
      "  hpgo generate --world=manhattan --nodes=10000 --output=map.g2o --ground_truth=truth.g2o\n"
      "  hpgo generate --world=city --dim=2 --outliers=0.05 --output=city.g2o\n"
      "  hpgo generate --world=trajectory --trajectory=00.txt --output=00.g2o\n"};
  return *command;
}

}  // namespace hpgo_cli
