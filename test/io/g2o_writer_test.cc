#include "hpgo/io/g2o_writer.h"

#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <random>

#include "gmock/gmock.h"
#include "hpgo/io/input_text.h"
#include "test/io/graph_text.h"

namespace hpgo {
namespace {

using ::testing::IsEmpty;

std::string TemporaryPath() {
  return ::testing::TempDir() + "/hpgo_writer_" + std::to_string(getpid()) + ".g2o";
}

template <typename File>
std::string Written(const File& file, const WriteOptions& options = WriteOptions()) {
  const std::string path = TemporaryPath();
  const Status status = WriteG2o(file, path, options);
  EXPECT_TRUE(status.ok()) << status.message();
  const Result<InputText> text = InputText::Read(path);
  EXPECT_TRUE(text.ok());
  std::filesystem::remove(path);
  return std::string(text->text());
}

std::string Golden(const std::string& name) {
  return std::string(InputText::Read(std::string(HPGO_TEST_DATA_DIR) + "/" + name)->text());
}

template <typename G>
bool SameBits(const G& a, const G& b) {
  return std::memcmp(a.data(), b.data(), G::kParams * sizeof(double)) == 0;
}
template <typename Matrix>
bool SameMatrix(const Matrix& a, const Matrix& b) {
  return std::memcmp(a.data(), b.data(), sizeof(Matrix)) == 0;
}

template <typename G>
void ExpectSameGraph(const PoseGraph<G>& a, const PoseGraph<G>& b) {
  ASSERT_EQ(a.nodes().size(), b.nodes().size());
  ASSERT_EQ(a.edges().size(), b.edges().size());
  ASSERT_EQ(a.priors().size(), b.priors().size());
  for (std::size_t k = 0; k < a.nodes().size(); ++k) {
    EXPECT_EQ(a.nodes()[k].id, b.nodes()[k].id);
    EXPECT_EQ(a.nodes()[k].fixed, b.nodes()[k].fixed);
    EXPECT_TRUE(SameBits(a.nodes()[k].pose, b.nodes()[k].pose)) << "node " << k;
  }
  for (std::size_t k = 0; k < a.edges().size(); ++k) {
    EXPECT_EQ(a.edges()[k].i, b.edges()[k].i);
    EXPECT_EQ(a.edges()[k].j, b.edges()[k].j);
    EXPECT_TRUE(SameBits(a.edges()[k].measurement, b.edges()[k].measurement)) << "edge " << k;
    EXPECT_TRUE(SameMatrix(a.edges()[k].information, b.edges()[k].information)) << "edge " << k;
  }
  for (std::size_t k = 0; k < a.priors().size(); ++k) {
    EXPECT_EQ(a.priors()[k].node, b.priors()[k].node);
    EXPECT_TRUE(SameBits(a.priors()[k].measurement, b.priors()[k].measurement)) << "prior " << k;
    EXPECT_TRUE(SameBits(a.priors()[k].offset, b.priors()[k].offset)) << "prior " << k;
    EXPECT_TRUE(SameMatrix(a.priors()[k].information, b.priors()[k].information)) << "prior " << k;
  }
}

// Random graphs with dense information, sparse ids and values of every size.
class RandomGraph {
 public:
  explicit RandomGraph(unsigned seed) : random_(seed) {}

  template <typename G>
  PoseGraph<G> Make() {
    PoseGraph<G> graph;
    for (int k = 0; k < 40; ++k) {
      GraphNode<G> node;
      node.id = static_cast<NodeId>(random_());
      node.pose = Pose<G>();
      node.fixed = k % 7 == 0;
      EXPECT_TRUE(graph.AddNode(node).ok());
    }
    for (int k = 0; k < 100; ++k) {
      GraphEdge<G> edge;
      edge.i = static_cast<int>(random_() % 40);
      edge.j = (edge.i + 1 + static_cast<int>(random_() % 39)) % 40;
      edge.measurement = Pose<G>();
      edge.information = Information<G>();
      EXPECT_TRUE(graph.AddEdge(edge).ok());
    }
    for (int k = 0; k < 10; ++k) {
      GraphPrior<G> prior;
      prior.node = static_cast<int>(random_() % 40);
      prior.measurement = Pose<G>();
      prior.information = Information<G>();
      if (G::kDim == 3 && k % 2 == 0) prior.offset = Pose<G>();
      if (k % 3 == 0) {
        const typename G::Vector t = prior.measurement.translation();
        prior.measurement = G();
        prior.measurement.translation() = t;
        prior.information.template rightCols<G::kRotationDof>().setZero();
        prior.information.template bottomRows<G::kRotationDof>().setZero();
      }
      EXPECT_TRUE(graph.AddPrior(prior).ok());
    }
    return graph;
  }

 private:
  double Value() { return normal_(random_) * std::pow(10.0, normal_(random_) * 3); }

  template <typename G>
  G Pose() {
    double params[G::kParams];
    for (double& param : params) param = Value();
    return G(params).Normalized();
  }

  template <typename G>
  typename G::Matrix Information() {
    typename G::Matrix a;
    for (int r = 0; r < G::kDof; ++r) {
      for (int c = 0; c < G::kDof; ++c) a(r, c) = normal_(random_);
    }
    const typename G::Matrix m = a * a.transpose() + G::Matrix::Identity();
    return m.template selfadjointView<Eigen::Upper>();
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
};

template <typename G>
class G2oWriterTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(G2oWriterTest, Groups);

TYPED_TEST(G2oWriterTest, RandomGraphsReadBackBitForBit) {
  WriteOptions options;
  options.write_fixed = true;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const PoseGraph<TypeParam> graph = RandomGraph(seed).Make<TypeParam>();
    const std::string text = Written(graph, options);
    ReadOptions strict;
    strict.strict = true;
    const GraphFile<TypeParam> again = FileOf<TypeParam>(text, strict);
    ExpectSameGraph(again.graph, graph);
    EXPECT_EQ(Written(again), text);
  }
}

TYPED_TEST(G2oWriterTest, WritesNoFixUnlessAsked) {
  const PoseGraph<TypeParam> graph = RandomGraph(1).Make<TypeParam>();
  EXPECT_EQ(Written(graph).find("FIX"), std::string::npos);
}

TYPED_TEST(G2oWriterTest, RejectsWhatCouldNotBeReadAgain) {
  const std::string path = TemporaryPath();
  PoseGraph<TypeParam> graph;
  GraphNode<TypeParam> node;
  for (node.id = 3; node.id < 5; ++node.id) ASSERT_TRUE(graph.AddNode(node).ok());
  graph.node(1).pose.translation()(0) = std::numeric_limits<double>::quiet_NaN();
  Status status = WriteG2o(graph, path);
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(status.message(), "node 4: its pose is not finite");
  graph.node(1).pose = TypeParam();
  graph.node(1).has_pose = false;
  EXPECT_EQ(WriteG2o(graph, path).message(), "node 4 has no pose");
  graph.node(1).has_pose = true;
  GraphEdge<TypeParam> edge;
  edge.i = 0;
  edge.j = 1;
  edge.information(1, 2) = std::numeric_limits<double>::infinity();
  ASSERT_TRUE(graph.AddEdge(edge).ok());
  EXPECT_EQ(WriteG2o(graph, path).message(), "edge 3 - 4 is not finite");
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(G2oWriter, GoldenFilesComeBackAsTheyAre) {
  EXPECT_EQ(Written(*ReadText(Golden("tiny_2d.g2o"))), Golden("tiny_2d.g2o"));
  EXPECT_EQ(Written(*ReadText(Golden("tiny_3d.g2o"))), Golden("tiny_3d.g2o"));
}

TEST(G2oWriter, ToroFilesBecomeG2o) {
  EXPECT_EQ(Written(*ReadText(Golden("toro_2d.graph"))),
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0.5\nVERTEX_SE2 2 0 0 0\n"
            "EDGE_SE2 0 1 1 0 0.5 10 1 2 20 3 30\nEDGE_SE2 1 0 1 0.125 0.5 10 1 2 20 3 30\n"
            "EQUIV 0 2\n");
}

TEST(G2oWriter, EdgesOnlyFilesStayEdgesOnly) {
  const std::string text = "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n# end\n";
  EXPECT_EQ(Written(*ReadText(text)), text);
}

TEST(G2oWriter, PosesMadeSinceComeAheadOfTheRecords) {
  GraphFile<SE2> file = FileOf<SE2>("# head\nEDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n# end\n");
  for (int k = 0; k < 2; ++k) {
    file.graph.node(k).pose = SE2(k, 0, 0);
    file.graph.node(k).has_pose = true;
  }
  EXPECT_EQ(Written(file),
            "# head\nVERTEX_SE2 1 0 0 0\nVERTEX_SE2 2 1 0 0\n"
            "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n# end\n");
}

TEST(G2oWriter, WhatWasAddedSinceComesLast) {
  GraphFile<SE2> file = FileOf<SE2>("VERTEX_SE2 5 0 0 0\nFIX 5\n# end\n");
  GraphNode<SE2> node;
  node.id = 6;
  node.fixed = true;
  ASSERT_TRUE(file.graph.AddNode(node).ok());
  GraphEdge<SE2> edge;
  edge.j = 1;
  ASSERT_TRUE(file.graph.AddEdge(edge).ok());
  GraphPrior<SE2> prior;
  ASSERT_TRUE(file.graph.AddPrior(prior).ok());
  EXPECT_EQ(Written(file),
            "VERTEX_SE2 6 0 0 0\nVERTEX_SE2 5 0 0 0\nFIX 5\n# end\n"
            "EDGE_SE2 5 6 0 0 0 1 0 0 1 0 1\nEDGE_PRIOR_SE2 5 0 0 0 1 0 0 1 0 1\n");
  WriteOptions options;
  options.write_fixed = true;
  EXPECT_THAT(Written(file, options), ::testing::HasSubstr("# end\nFIX 6\nEDGE_SE2"));
}

TEST(G2oWriter, NodesSetFreeLeaveTheirFixLine) {
  GraphFile<SE2> file = FileOf<SE2>("VERTEX_SE2 5 0 0 0\nVERTEX_SE2 6 0 0 0\nFIX 5 6\nFIX 6\n");
  file.graph.node(1).fixed = false;
  EXPECT_EQ(Written(file), "VERTEX_SE2 5 0 0 0\nVERTEX_SE2 6 0 0 0\nFIX 5\n");
}

TEST(G2oWriter, MissingParametersStayMissing) {
  const std::string text =
      "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\nEDGE_SE3_XYZ_PRIOR 1 4 1 2 3 1 0 0 1 0 1\n";
  EXPECT_EQ(Written(*ReadText(text)), text);
}

TEST(G2oWriter, ChangedOffsetsGetAParameterOfTheirOwn) {
  GraphFile<SE3> file = FileOf<SE3>(
      "PARAMS_SE3OFFSET 4 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\n"
      "EDGE_SE3_XYZ_PRIOR 1 4 1 2 3 1 0 0 1 0 1\n");
  file.graph.prior(0).offset.translation()(0) = 9;
  EXPECT_EQ(Written(file),
            "PARAMS_SE3OFFSET 5 9 0 0 0 0 0 1\nPARAMS_SE3OFFSET 4 0 0 0 0 0 0 1\n"
            "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\nEDGE_SE3_XYZ_PRIOR 1 5 1 2 3 1 0 0 1 0 1\n");
}

TEST(G2oWriter, PlanarPriorsHaveNoOffset) {
  PoseGraph<SE2> graph;
  ASSERT_TRUE(graph.AddNode(GraphNode<SE2>()).ok());
  GraphPrior<SE2> prior;
  prior.offset = SE2(1, 0, 0);
  ASSERT_TRUE(graph.AddPrior(prior).ok());
  EXPECT_EQ(WriteG2o(graph, TemporaryPath()).message(),
            "prior at node 0 has an offset, which a 2D file cannot hold");
}

TEST(G2oWriter, PublicSetsReadBackBitForBit) {
  const std::string folder = HPGO_SHARED_DATA_DIR;
  if (!std::filesystem::exists(folder + "/g2o")) GTEST_SKIP() << "no public data sets here";
  for (const char* name :
       {"g2o/intel.g2o", "g2o/parking-garage.g2o", "kitti/graphs/kitti_06.g2o"}) {
    SCOPED_TRACE(name);
    const Result<AnyGraphFile> file = ReadG2o(folder + "/" + name, ReadOptions(), nullptr);
    ASSERT_TRUE(file.ok());
    const Result<AnyGraphFile> again = ReadText(Written(*file));
    ASSERT_TRUE(again.ok());
    std::visit(
        [&](const auto& f) {
          using File = std::decay_t<decltype(f)>;
          ExpectSameGraph(f.graph, std::get<File>(*again).graph);
          EXPECT_THAT(f.verbatim, IsEmpty());
        },
        *file);
  }
}

}  // namespace
}  // namespace hpgo
