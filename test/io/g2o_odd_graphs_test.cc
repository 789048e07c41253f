// Odd graphs of g2o and TORO files, with the exact text of their errors and warnings: nodes, edges,
// parameters.

#include <cmath>
#include <string>

#include "gmock/gmock.h"
#include "hpgo/io/g2o_writer.h"
#include "test/io/graph_text.h"
#include "test/io/two_nodes.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(OddGraphs, FixAndEdgesMayComeBeforeTheirVertices) {
  const GraphFile<SE2> file = FileOf<SE2>(std::string("FIX 1 0\n") + kEdge + "FIX 1\n" + kTwo);
  ASSERT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_EQ(file.graph.edges().size(), 1u);
  for (const GraphNode<SE2>& node : file.graph.nodes()) {
    EXPECT_TRUE(node.fixed);
    EXPECT_TRUE(node.has_pose);
  }
  EXPECT_EQ(file.graph.nodes()[1].pose.data()[0], 1);
}

TEST(OddGraphs, FixMustNameNodes) {
  EXPECT_EQ(ErrorOf(Two("FIX 0 2\n")), "f:3: FIX of node 2, which is not there: 'FIX 0 2'");
  EXPECT_EQ(ErrorOf(Two("FIX\n")), "f:3: FIX names no node: 'FIX'");
  EXPECT_EQ(ErrorOf(Two("FIX 0 a\n")), "f:3: FIX: not an id: 'a'");
  const GraphFile<SE2> landmark = FileOf<SE2>(Two("VERTEX_XY 5 1 1\nFIX 0 5\n"));
  EXPECT_TRUE(landmark.graph.nodes()[0].fixed);
}

TEST(OddGraphs, FilesWithoutVerticesHaveNoPoses) {
  ReadReport report;
  const Result<AnyGraphFile> file =
      ReadText("\nEDGE_SE2 5 7 1 0 0 1 0 0 1 0 1\nEDGE_SE2 7 6 1 0 0 1 0 0 1 0 1\nFIX 6\n",
               ReadOptions(), &report);
  ASSERT_TRUE(file.ok());
  EXPECT_TRUE(report.edges_only);
  EXPECT_THAT(report.warnings, IsEmpty());
  const auto& nodes = std::get<GraphFile<SE2>>(*file).graph.nodes();
  ASSERT_EQ(nodes.size(), 3u);
  EXPECT_EQ(nodes[1].id, 7);
  EXPECT_FALSE(nodes[1].has_pose);
  EXPECT_TRUE(nodes[2].fixed);
}

TEST(OddGraphs, AMissingVertexIsAnErrorOrComposed) {
  const std::string text =
      Two("EDGE_SE2 1 2 2 0 0.5 1 0 0 1 0 1\nEDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n");
  EXPECT_EQ(ErrorOf(text), "f:3: no vertex 2: 'EDGE_SE2 1 2 2 0 0.5 1 0 0 1 0 1'");
  ReadOptions options;
  options.create_missing = true;
  EXPECT_THAT(WarningsOf(text, options),
              ElementsAre("f:3: no vertex 2, its pose is composed from the edges: "
                          "'EDGE_SE2 1 2 2 0 0.5 1 0 0 1 0 1'",
                          "f:4: no vertex 3, its pose is composed from the edges: "
                          "'EDGE_SE2 2 3 1 0 0 1 0 0 1 0 1'"));
  const GraphFile<SE2> file = FileOf<SE2>(text, options);
  ASSERT_EQ(file.graph.nodes().size(), 4u);
  EXPECT_DOUBLE_EQ(file.graph.nodes()[2].pose.data()[0], 3);
  EXPECT_DOUBLE_EQ(file.graph.nodes()[3].pose.data()[0], 3 + std::cos(0.5));
  EXPECT_TRUE(file.graph.nodes()[3].has_pose);
  EXPECT_EQ(ErrorOf(Two("EDGE_PRIOR_SE2 4 0 0 0 1 0 0 1 0 1\n")),
            "f:3: no vertex 4: 'EDGE_PRIOR_SE2 4 0 0 0 1 0 0 1 0 1'");
}

TEST(OddGraphs, TwoAndThreeDimensionsDoNotMix) {
  EXPECT_EQ(ErrorOf(Two("VERTEX_SE3:QUAT 5 0 0 0 0 0 0 1\n")),
            "f:3: 3D record in a 2D file: 'VERTEX_SE3:QUAT 5 0 0 0 0 0 0 1'");
  EXPECT_EQ(ErrorOf(Two3d("EDGE_PRIOR_SE2_XY 0 1 2 1 0 1\n")),
            "f:3: 2D record in a 3D file: 'EDGE_PRIOR_SE2_XY 0 1 2 1 0 1'");
}

TEST(OddGraphs, DuplicateVerticesMustBeIdentical) {
  EXPECT_EQ(ErrorOf(Two("VERTEX_SE2 1 1 0 0.1\n")),
            "f:3: vertex 1 was given in line 2 with another pose: 'VERTEX_SE2 1 1 0 0.1'");
  const std::string same = Two("VERTEX_SE2 1 1.0 0 0\n");
  EXPECT_THAT(
      WarningsOf(same),
      ElementsAre("f:3: vertex 1 was given in line 2 with the same pose: 'VERTEX_SE2 1 1.0 0 0'"));
  EXPECT_EQ(FileOf<SE2>(same).graph.nodes().size(), 2u);
  EXPECT_EQ(ErrorOf(same, Strict()),
            "f:3: vertex 1 was given in line 2 with the same pose: 'VERTEX_SE2 1 1.0 0 0'");
}

TEST(OddGraphs, SeveralEdgesBetweenTwoNodesAreKept) {
  EXPECT_EQ(FileOf<SE2>(Two(std::string(kEdge) + kEdge)).graph.edges().size(), 2u);
}

TEST(OddGraphs, IdsMayBeHugeNegativeSparseAndOutOfOrder) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "VERTEX_SE2 8646911284551352320 0 0 0\nVERTEX_SE2 9223372036854775807 0 0 0\n"
      "VERTEX_SE2 -5 0 0 0\nVERTEX_SE2 3 0 0 0\n"
      "EDGE_SE2 9223372036854775807 -5 1 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(file.graph.nodes().size(), 4u);
  EXPECT_EQ(file.graph.nodes()[0].id, 8646911284551352320);
  EXPECT_EQ(file.graph.nodes()[2].id, -5);
  EXPECT_EQ(file.graph.edges()[0].i, 1);
  EXPECT_EQ(file.graph.edges()[0].j, 2);
  EXPECT_EQ(ErrorOf("VERTEX_SE2 9223372036854775808 0 0 0\n"),
            "f:1: VERTEX_SE2: id beyond 64 bits: '9223372036854775808'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 1.0 0 0 0\n"), "f:1: VERTEX_SE2: not an id: '1.0'");
}

TEST(OddGraphs, SelfEdgeIsAnError) {
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n")),
            "f:3: edge from node 1 to itself: 'EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1'");
}

TEST(OddGraphs, APriorWithoutItsParameterTakesTheIdentity) {
  const std::string text = Two3d("EDGE_SE3_XYZ_PRIOR 1 4 1 2 3 1 0 0 1 0 1\n");
  EXPECT_THAT(WarningsOf(text), ElementsAre("f:3: no PARAMS_SE3OFFSET 4, the identity is taken: "
                                            "'EDGE_SE3_XYZ_PRIOR 1 4 1 2 3 1 0 0 1 0 1'"));
  EXPECT_EQ(FileOf<SE3>(text).graph.priors()[0].offset.translation().norm(), 0);
  EXPECT_EQ(ErrorOf(text, Strict()),
            "f:3: no PARAMS_SE3OFFSET 4, the identity is taken: "
            "'EDGE_SE3_XYZ_PRIOR 1 4 1 2 3 1 0 0 1 0 1'");
  const GraphFile<SE3> later = FileOf<SE3>(text + "PARAMS_SE3OFFSET 4 1 2 3 0 0 0 1\n", Strict());
  EXPECT_EQ(later.graph.priors()[0].offset.translation()(2), 3);
}

TEST(OddGraphs, AParameterGivenTwiceMustBeIdentical) {
  const std::string text = Two3d("PARAMS_SE3OFFSET 4 1 2 3 0 0 0 1\nPARAMS_SE3OFFSET 4 1 2 ");
  EXPECT_THAT(WarningsOf(text + "3 0 0 0 1\n"), IsEmpty());
  EXPECT_EQ(ErrorOf(text + "4 0 0 0 1\n"),
            "f:4: parameter 4 was given with another pose: 'PARAMS_SE3OFFSET 4 1 2 4 0 0 0 1'");
}

TEST(OddGraphs, EquivalentNodesAreMerged) {
  const std::string text =
      "VERTEX_SE2 4 9 9 9\nVERTEX_SE2 1 0 0 0\nVERTEX_SE2 2 1 0 0\nFIX 4\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 4 -1 0 0 1 0 0 1 0 1\n"
      "EDGE_PRIOR_SE2 4 0 0 0 1 0 0 1 0 1\nEQUIV 4 1\n";
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:8: the nodes it names are one node, 1 line: 'EQUIV'"));
  const GraphFile<SE2> file = FileOf<SE2>(text);
  ASSERT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_EQ(file.graph.nodes()[0].id, 1);
  EXPECT_EQ(file.graph.nodes()[0].pose.data()[0], 0);
  EXPECT_TRUE(file.graph.nodes()[0].fixed);
  ASSERT_EQ(file.graph.edges().size(), 2u);
  EXPECT_EQ(file.graph.edges()[1].j, 0);
  EXPECT_EQ(file.graph.priors()[0].node, 0);
  std::string written;
  ASSERT_TRUE(FormatG2o(file, WriteOptions(), &written).ok());
  EXPECT_EQ(written,
            "VERTEX_SE2 4 0 0 0\nVERTEX_SE2 1 0 0 0\nVERTEX_SE2 2 1 0 0\nFIX 4\n"
            "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\nEDGE_SE2 2 1 -1 0 0 1 0 0 1 0 1\n"
            "EDGE_PRIOR_SE2 1 0 0 0 1 0 0 1 0 1\nEQUIV 4 1\n");
}

TEST(OddGraphs, EquivalencesChainAndGiveThePoseThatIsThere) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "EQUIV 7 5\nEQUIV 9 7\nEQUIV 3 9\nVERTEX_SE2 9 1 2 3\nVERTEX_SE2 7 4 5 6\n"
      "VERTEX_SE2 6 0 0 0\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_EQ(file.graph.nodes()[0].id, 3);
  EXPECT_EQ(file.graph.nodes()[0].pose.data()[0], 1);
  EXPECT_EQ(file.graph.edges()[0].i, 0);
}

TEST(OddGraphs, AnEdgeWithinMergedNodesIsKept) {
  const std::string text = Two(std::string(kEdge) + "EQUIV 0 1\n");
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:3: nodes 0 and 1 are one node by EQUIV, the edge is kept as it is: "
                          "'EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1'",
                          "f:4: the nodes it names are one node, 1 line: 'EQUIV'"));
  EXPECT_EQ(FileOf<SE2>(text).graph.edges().size(), 0u);
  EXPECT_EQ(FileOf<SE2>(text).verbatim.size(), 2u);
  EXPECT_EQ(ErrorOf(Two("EQUIV 0\n")), "f:3: EQUIV needs 2 numbers, has 1: 'EQUIV 0'");
}

}  // namespace
}  // namespace hpgo
