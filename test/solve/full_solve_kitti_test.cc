// The optimized KITTI graphs against the published ground truth: the figures an independent program
// (Gauss-Newton from dead reckoning) established.
#include <string>
#include <variant>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/evaluate/ground_plane.h"
#include "hpgo/graph/edge_classes.h"
#include "hpgo/io/g2o_reader.h"
#include "hpgo/io/trajectory.h"
#include "hpgo/solve/full_solve.h"
#include "test/evaluate/kitti_figures.h"

namespace hpgo {
namespace {

class KittiOptimumTest : public ::testing::TestWithParam<KittiFigures> {};

TEST_P(KittiOptimumTest, ReproducesThePublishedFigures) {
  const std::string folder = std::string(HPGO_SHARED_DATA_DIR) + "/kitti";
  const std::string name = GetParam().sequence;
  Result<AnyGraphFile> file =
      ReadG2o(folder + "/graphs/kitti_" + name + ".g2o", ReadOptions(), nullptr);
  if (!file.ok() && file.status().code() == StatusCode::kUnreadable) {
    GTEST_SKIP() << file.status().ToString();
  }
  ASSERT_TRUE(file.ok()) << file.status().ToString();
  const Result<Trajectory> camera = ReadTrajectory(
      folder + "/gt/" + name + ".txt", TrajectoryFormat::kKitti, ReadOptions(), nullptr);
  ASSERT_TRUE(camera.ok()) << camera.status().ToString();
  PoseGraph2d& graph = std::get<GraphFile<SE2>>(*file).graph;
  const FullSolveReport report = SolveFull(FullSolveOptions(), &graph);
  ASSERT_TRUE(report.status.ok()) << report.status.ToString();

  const std::vector<SE2> reference = ProjectToPlane(camera->poses, GroundPlane::kXz);
  std::vector<SE2> estimate;
  for (const int node : IdOrder(graph)) estimate.push_back(graph.nodes()[node].pose);
  ExpectFigures(GetParam(), estimate, reference);
}

INSTANTIATE_TEST_SUITE_P(Sequences, KittiOptimumTest,
                         ::testing::Values(KittiFigures{"00", 0.01076, 3.0e-5, 2.03},
                                           KittiFigures{"02", 0.00989, 2.8e-5, 5.21},
                                           KittiFigures{"06", 0.01203, 1.3e-5, 2.12},
                                           KittiFigures{"07", 0.01820, 2.1e-5, 1.49}),
                         [](const auto& instance) { return instance.param.sequence; });

}  // namespace
}  // namespace hpgo
