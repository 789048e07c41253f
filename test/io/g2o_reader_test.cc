// What each tag means, on the golden files of test/data.
#include "hpgo/io/g2o_reader.h"

#include <cmath>
#include <filesystem>

#include "gmock/gmock.h"
#include "test/io/graph_text.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;

template <typename G>
GraphFile<G> Golden(const std::string& name, ReadReport* report,
                    const ReadOptions& options = ReadOptions()) {
  const std::string path = std::string(HPGO_TEST_DATA_DIR) + "/" + name;
  Result<AnyGraphFile> file = ReadG2o(path, options, report);
  EXPECT_TRUE(file.ok()) << file.status().message();
  return std::get<GraphFile<G>>(std::move(file).value());
}

SE2::Matrix Symmetric3(double xx, double xy, double xt, double yy, double yt, double tt) {
  SE2::Matrix m;
  m << xx, xy, xt, xy, yy, yt, xt, yt, tt;
  return m;
}

TEST(G2oReader, PlanarTags) {
  ReadReport report;
  const GraphFile<SE2> file = Golden<SE2>("tiny_2d.g2o", &report);
  const PoseGraph<SE2>& graph = file.graph;
  ASSERT_EQ(graph.nodes().size(), 5u);
  EXPECT_EQ(graph.nodes()[2].id, 3);
  EXPECT_EQ(graph.nodes()[2].pose.data()[1], 1);
  EXPECT_EQ(graph.nodes()[2].pose.angle(), -1.5707963267948966);
  EXPECT_TRUE(graph.nodes()[0].fixed);
  EXPECT_FALSE(graph.nodes()[1].fixed);
  ASSERT_EQ(graph.edges().size(), 4u);
  EXPECT_EQ(graph.edges()[1].j, 3);
  EXPECT_EQ(graph.edges()[0].information, Symmetric3(10, 1, 0.5, 20, 0.25, 30));
  ASSERT_EQ(graph.priors().size(), 2u);
  EXPECT_EQ(graph.priors()[0].node, 3);
  EXPECT_EQ(graph.priors()[0].measurement.angle(), 3.1);
  EXPECT_EQ(graph.priors()[0].information, Symmetric3(1, 0, 0, 1, 0, 5));
  EXPECT_EQ(graph.priors()[1].node, 2);
  EXPECT_EQ(graph.priors()[1].measurement.angle(), 0);
  EXPECT_EQ(graph.priors()[1].information, Symmetric3(4, 0.5, 0, 3, 0, 0));
  EXPECT_EQ(report.comments, 1);
  EXPECT_EQ(report.landmarks, 2);
  EXPECT_EQ(report.lines, 15);
  EXPECT_EQ(report.tags["EDGE_SE2"], 4);
  EXPECT_EQ(report.semidefinite_informations, 0);
}

TEST(G2oReader, SpatialTags) {
  ReadReport report;
  const GraphFile<SE3> file = Golden<SE3>("tiny_3d.g2o", &report);
  const PoseGraph<SE3>& graph = file.graph;
  ASSERT_EQ(graph.nodes().size(), 3u);
  EXPECT_EQ(graph.nodes()[1].pose.rotation().z(), 0.6);
  EXPECT_TRUE(graph.nodes()[2].fixed);
  ASSERT_EQ(graph.edges().size(), 2u);
  const SE3::Matrix& m = graph.edges()[0].information;
  EXPECT_EQ(m(0, 5), 0.3);
  EXPECT_EQ(m(5, 0), 0.3);
  EXPECT_EQ(m(2, 3), 0.7);
  EXPECT_EQ(m(5, 5), 22);
  ASSERT_EQ(graph.priors().size(), 3u);
  EXPECT_EQ(graph.priors()[0].offset.translation().norm(), 0);
  EXPECT_EQ(graph.priors()[1].offset.translation()(1), -0.2);
  EXPECT_EQ(graph.priors()[1].information(4, 4), 0);
  EXPECT_EQ(graph.priors()[2].measurement.translation()(2), -2);
  EXPECT_EQ(graph.priors()[2].measurement.rotation().w(), 1);
  EXPECT_EQ(graph.priors()[2].information(0, 1), 0.5);
  EXPECT_EQ(graph.priors()[2].information(2, 2), 2);
  EXPECT_TRUE(graph.priors()[2].information.bottomRows<3>().isZero(0));
  EXPECT_EQ(report.semidefinite_informations, 1);
}

TEST(G2oReader, ToroOrderOfPlanarInformation) {
  ReadReport report;
  const GraphFile<SE2> toro = Golden<SE2>("toro_2d.graph", &report);
  ASSERT_EQ(toro.graph.nodes().size(), 2u) << "EQUIV makes one of nodes 0 and 2";
  EXPECT_EQ(toro.graph.nodes()[1].pose.angle(), 0.5);
  EXPECT_EQ(report.merged_nodes, 1);
  ASSERT_EQ(toro.graph.edges().size(), 2u);
  for (const GraphEdge<SE2>& edge : toro.graph.edges()) {
    EXPECT_EQ(edge.information, Symmetric3(10, 1, 2, 20, 3, 30));
  }
  EXPECT_EQ(report.tags["EQUIV"], 1);
  ReadOptions options;
  options.edge2_order = Edge2Order::kRowMajor;
  const std::string text = "VERTEX2 0 0 0 0\nVERTEX2 1 0 0 0\nEDGE2 0 1 1 0 0.5 10 1 2 20 3 30\n";
  EXPECT_EQ(FileOf<SE2>(text, options).graph.edges()[0].information,
            Symmetric3(10, 1, 2, 20, 3, 30));
}

TEST(G2oReader, RowMajorInformationInToroOrderSaysSo) {
  EXPECT_EQ(ErrorOf("EDGE2 0 1 1 0 0 1 0 0 1 0 1\n"),
            "f:1: information is not positive semi-definite, smallest eigenvalue -0.618034 (in "
            "TORO's order xx xy yy tt xt yt; --row_major_edge2 reads it row by row): "
            "'1 0 0 1 0 1'");
}

TEST(G2oReader, ToroPosesInSpaceAreRollPitchYaw) {
  ReadReport report;
  const GraphFile<SE3> file = Golden<SE3>("toro_3d.graph", &report);
  const double roll = 0.1, pitch = 0.2, yaw = 0.3;
  Eigen::Matrix3d rx, ry, rz;
  rx << 1, 0, 0, 0, std::cos(roll), -std::sin(roll), 0, std::sin(roll), std::cos(roll);
  ry << std::cos(pitch), 0, std::sin(pitch), 0, 1, 0, -std::sin(pitch), 0, std::cos(pitch);
  rz << std::cos(yaw), -std::sin(yaw), 0, std::sin(yaw), std::cos(yaw), 0, 0, 0, 1;
  const Eigen::Matrix3d R = rz * ry * rx;
  EXPECT_TRUE(file.graph.nodes()[1].pose.matrix().isApprox(R, 1e-14));
  EXPECT_TRUE(file.graph.edges()[0].measurement.matrix().isApprox(R, 1e-14));
  // The error is half of a small rotation vector: four times the information, twice across.
  const SE3::Matrix& m = file.graph.edges()[0].information;
  EXPECT_EQ(m(0, 0), 10);
  EXPECT_EQ(m(1, 2), 6);
  EXPECT_EQ(m(0, 3), 2 * 3);
  EXPECT_EQ(m(4, 1), 2 * 8);
  EXPECT_EQ(m(3, 4), 4 * 13);
  EXPECT_EQ(m(5, 5), 4 * 120);
  EXPECT_THAT(report.warnings, ElementsAre(std::string(HPGO_TEST_DATA_DIR) +
                                           "/toro_3d.graph:3: information of Euler angles turned "
                                           "into that of the quaternion in 1 line: 'EDGE3'"));
}

TEST(G2oReader, NodesStandInTheOrderTheyAreNamed) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "EDGE_SE2 4 2 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 9 0 0 0\nVERTEX_SE2 2 0 0 0\n"
      "VERTEX_SE2 4 0 0 0\n");
  ASSERT_EQ(file.graph.nodes().size(), 3u);
  EXPECT_EQ(file.graph.nodes()[0].id, 4);
  EXPECT_EQ(file.graph.nodes()[1].id, 2);
  EXPECT_EQ(file.graph.nodes()[2].id, 9);
}

TEST(G2oReader, AnglesStayAsTheyAre) {
  EXPECT_EQ(FileOf<SE2>("VERTEX_SE2 0 0 0 7.5\n").graph.nodes()[0].pose.angle(), 7.5);
}

struct PublicSet {
  const char* path;
  std::size_t nodes;
  std::size_t edges;
};

TEST(G2oReader, ReadsThePublicSets) {
  const std::string folder = HPGO_SHARED_DATA_DIR;
  if (!std::filesystem::exists(folder + "/g2o")) GTEST_SKIP() << "no public data sets here";
  for (const PublicSet& set :
       {PublicSet{"g2o/M3500.g2o", 3500, 5453}, PublicSet{"g2o/intel.g2o", 1728, 2512},
        PublicSet{"g2o/parking-garage.g2o", 1661, 6275},
        PublicSet{"g2o/sphere2500.g2o", 2500, 4949}, PublicSet{"g2o/torus3D.g2o", 5000, 9048},
        PublicSet{"kitti/graphs/kitti_00.g2o", 4541, 4676},
        PublicSet{"kitti/graphs/kitti_07.g2o", 1101, 1106}}) {
    SCOPED_TRACE(set.path);
    ReadReport report;
    ReadOptions options;
    options.strict = true;
    const Result<AnyGraphFile> file = ReadG2o(folder + "/" + set.path, options, &report);
    ASSERT_TRUE(file.ok()) << file.status().message();
    std::visit(
        [&](const auto& f) {
          EXPECT_EQ(f.graph.nodes().size(), set.nodes);
          EXPECT_EQ(f.graph.edges().size(), set.edges);
        },
        *file);
    EXPECT_EQ(report.edges_only, std::string(set.path).find("kitti") == 0);
  }
}

}  // namespace
}  // namespace hpgo
