// Dead reckoning of the KITTI graphs against the published ground truth: figures that an
// independent program established, so the whole chain of plane, alignment and segments is checked.
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/evaluate/ground_plane.h"
#include "test/evaluate/kitti_figures.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

class KittiDeadReckoningTest : public ::testing::TestWithParam<KittiFigures> {};

std::vector<SE2> ComposeOdometry(const std::string& path) {
  std::ifstream file(path);
  std::vector<SE2> poses(1);
  std::string line, tag;
  while (std::getline(file, line)) {
    std::istringstream fields(line);
    std::size_t i, j;
    double x, y, theta;
    if (!(fields >> tag >> i >> j >> x >> y >> theta)) continue;
    if (i + 1 == poses.size() && j == poses.size()) {
      poses.push_back(poses.back() * SE2(x, y, theta));
    }
  }
  return poses;
}

std::vector<SE3> ReadGroundTruth(const std::string& path) {
  std::ifstream file(path);
  std::vector<SE3> poses;
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> m;
  while (true) {
    for (int k = 0; k < 12; ++k) file >> m.data()[k];
    if (!file) return poses;
    poses.emplace_back(m.col(3), Eigen::Quaterniond(Eigen::Matrix3d(m.leftCols<3>())).normalized());
  }
}

TEST_P(KittiDeadReckoningTest, ReproducesThePublishedFigures) {
  const std::string folder = std::string(HPGO_SHARED_DATA_DIR) + "/kitti";
  const std::string name = GetParam().sequence;
  const std::vector<SE3> camera = ReadGroundTruth(folder + "/gt/" + name + ".txt");
  if (camera.empty()) GTEST_SKIP() << "no KITTI data in " << folder;
  const std::vector<SE2> reference = ProjectToPlane(camera, GroundPlane::kXz);
  const std::vector<SE2> estimate = ComposeOdometry(folder + "/graphs/kitti_" + name + ".g2o");
  ExpectFigures(GetParam(), estimate, reference);
}

INSTANTIATE_TEST_SUITE_P(Sequences, KittiDeadReckoningTest,
                         ::testing::Values(KittiFigures{"00", 0.01570, 9.9e-5, 20.6},
                                           KittiFigures{"02", 0.01719, 8.1e-5, 32.6},
                                           KittiFigures{"06", 0.01170, 4.5e-5, 3.2},
                                           KittiFigures{"07", 0.01584, 1.5e-4, 3.1},
                                           KittiFigures{"08", 0.01764, 9.5e-5, 14.7}),
                         [](const auto& instance) { return instance.param.sequence; });

}  // namespace
}  // namespace hpgo
