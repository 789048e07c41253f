// Every odd case of the g2o and TORO formats, with the exact text of its error or warning.
#include <cmath>
#include <limits>

#include "gmock/gmock.h"
#include "hpgo/io/g2o_writer.h"
#include "test/io/graph_text.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr char kTwo[] = "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n";
constexpr char kEdge[] = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
constexpr char kTwo3d[] = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 0 0 0 0 0 1\n";
constexpr char kUnit3d[] = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n";

std::string Two(const std::string& rest) { return kTwo + rest; }
std::string Two3d(const std::string& rest) { return kTwo3d + rest; }

ReadOptions Strict() {
  ReadOptions options;
  options.strict = true;
  return options;
}

TEST(OddCases, CommentsBlankLinesAndSpacesAreSkipped) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "# comment\n\n  \t\n  # another\n VERTEX_SE2  0\t0 0 0  \n\nVERTEX_SE2 1 1 0 0 # first\n");
  EXPECT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_THAT(file.verbatim, ElementsAre("# comment", "  # another"));
}

TEST(OddCases, CarriageReturnsAreSkipped) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "VERTEX_SE2 0 0 0 0\r\n\r\nVERTEX_SE2 1 1 0 0.5\r\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 2\r\n");
  EXPECT_EQ(file.graph.nodes()[1].pose.angle(), 0.5);
  EXPECT_EQ(file.graph.edges()[0].information(2, 2), 2);
}

TEST(OddCases, CarriageReturnsOfKeptLinesStay) {
  const std::string text = "VERTEX_SE2 0 0 0 0\n# note\r\r\n# one\r\nTAG 1\r\r\r\n";
  const GraphFile<SE2> file = FileOf<SE2>(text);
  EXPECT_THAT(file.verbatim, ElementsAre("# note\r\r", "# one", "TAG 1\r\r\r"));
  std::string written;
  ASSERT_TRUE(FormatG2o(file, WriteOptions(), &written).ok());
  EXPECT_EQ(written, "VERTEX_SE2 0 0 0 0\n# note\r\r\n# one\nTAG 1\r\r\r\n");
  EXPECT_EQ(FileOf<SE2>(written).verbatim, file.verbatim);
}

TEST(OddCases, ByteOrderMarkIsStripped) {
  const GraphFile<SE2> file = FileOf<SE2>("\xEF\xBB\xBFVERTEX_SE2 7 1 2 3\n");
  EXPECT_EQ(file.graph.nodes()[0].id, 7);
}

TEST(OddCases, LastLineNeedsNoEnd) {
  EXPECT_EQ(FileOf<SE2>("VERTEX_SE2 7 1 2 3").graph.nodes()[0].pose.angle(), 3);
}

TEST(OddCases, FixAndEdgesMayComeBeforeTheirVertices) {
  const GraphFile<SE2> file = FileOf<SE2>(std::string("FIX 1 0\n") + kEdge + "FIX 1\n" + kTwo);
  ASSERT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_EQ(file.graph.edges().size(), 1u);
  for (const GraphNode<SE2>& node : file.graph.nodes()) {
    EXPECT_TRUE(node.fixed);
    EXPECT_TRUE(node.has_pose);
  }
  EXPECT_EQ(file.graph.nodes()[1].pose.data()[0], 1);
}

TEST(OddCases, FixMustNameNodes) {
  EXPECT_EQ(ErrorOf(Two("FIX 0 2\n")), "f:3: FIX of node 2, which is not there: 'FIX 0 2'");
  EXPECT_EQ(ErrorOf(Two("FIX\n")), "f:3: FIX names no node: 'FIX'");
  EXPECT_EQ(ErrorOf(Two("FIX 0 a\n")), "f:3: FIX: not an id: 'a'");
  const GraphFile<SE2> landmark = FileOf<SE2>(Two("VERTEX_XY 5 1 1\nFIX 0 5\n"));
  EXPECT_TRUE(landmark.graph.nodes()[0].fixed);
}

TEST(OddCases, UnknownTagsAreKeptWithOneWarningEach) {
  const std::string text = Two("VERTEX_CAM 4 1 2 3\nROBOTLASER1 0 1\nVERTEX_CAM 5 nan\n") + kEdge;
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:3: unknown tag, 2 lines kept as they are: 'VERTEX_CAM'",
                          "f:4: unknown tag, 1 line kept as they are: 'ROBOTLASER1'"));
  EXPECT_THAT(FileOf<SE2>(text).verbatim,
              ElementsAre("VERTEX_CAM 4 1 2 3", "ROBOTLASER1 0 1", "VERTEX_CAM 5 nan"));
  EXPECT_EQ(ErrorOf(text, Strict()), "f:3: unknown tag: 'VERTEX_CAM'");
}

TEST(OddCases, TagsAreCaseSensitive) {
  EXPECT_EQ(ErrorOf(Two("edge_se2 0 1\n"), Strict()), "f:3: unknown tag: 'edge_se2'");
}

TEST(OddCases, LandmarksAreCountedAndKept) {
  ReadReport report;
  const std::string text =
      Two("VERTEX_XY 9 1 2\nEDGE_SE2_XY 0 9 1 1 1 0 1\nEDGE_SE2_XY 1 9 1 1 1 0 1\n");
  ASSERT_TRUE(ReadText(text, ReadOptions(), &report).ok());
  EXPECT_EQ(report.landmarks, 3);
  EXPECT_EQ(report.tags["EDGE_SE2_XY"], 2);
  EXPECT_THAT(
      report.warnings,
      ElementsAre("f:3: landmarks are not optimized, 1 line kept as they are: 'VERTEX_XY'",
                  "f:4: landmarks are not optimized, 2 lines kept as they are: 'EDGE_SE2_XY'"));
  EXPECT_EQ(ErrorOf(text, Strict()), "f:3: landmarks are not optimized: 'VERTEX_XY'");
  EXPECT_THAT(
      WarningsOf(Two3d("VERTEX_TRACKXYZ 9 1 2 3\nEDGE_SE3_TRACKXYZ 0 9 0 1 1 1 1 0 0 1 0 1\n")),
      ElementsAre(
          "f:3: landmarks are not optimized, 1 line kept as they are: 'VERTEX_TRACKXYZ'",
          "f:4: landmarks are not optimized, 1 line kept as they are: 'EDGE_SE3_TRACKXYZ'"));
}

TEST(OddCases, FilesWithoutVerticesHaveNoPoses) {
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

TEST(OddCases, AMissingVertexIsAnErrorOrComposed) {
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

TEST(OddCases, TwoAndThreeDimensionsDoNotMix) {
  EXPECT_EQ(ErrorOf(Two("VERTEX_SE3:QUAT 5 0 0 0 0 0 0 1\n")),
            "f:3: 3D record in a 2D file: 'VERTEX_SE3:QUAT 5 0 0 0 0 0 0 1'");
  EXPECT_EQ(ErrorOf(Two3d("EDGE_PRIOR_SE2_XY 0 1 2 1 0 1\n")),
            "f:3: 2D record in a 3D file: 'EDGE_PRIOR_SE2_XY 0 1 2 1 0 1'");
}

TEST(OddCases, DuplicateVerticesMustBeIdentical) {
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

TEST(OddCases, SeveralEdgesBetweenTwoNodesAreKept) {
  EXPECT_EQ(FileOf<SE2>(Two(std::string(kEdge) + kEdge)).graph.edges().size(), 2u);
}

TEST(OddCases, IdsMayBeHugeNegativeSparseAndOutOfOrder) {
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

TEST(OddCases, QuaternionsOffUnitAreNormalizedWithAWarning) {
  const std::string text = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1.01\n";
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:1: quaternion of length 1.01 normalized: '0 0 0 1.01'"));
  EXPECT_EQ(FileOf<SE3>(text).graph.nodes()[0].pose.rotation().w(), 1);
  EXPECT_EQ(ErrorOf(text, Strict()), "f:1: quaternion of length 1.01 normalized: '0 0 0 1.01'");
  EXPECT_THAT(WarningsOf(Two3d("EDGE_SE3:QUAT 0 1 1 0 0 0 0 3 4").substr(0) + kUnit3d),
              ElementsAre("f:3: quaternion of length 5 normalized: '0 0 3 4'"));
}

TEST(OddCases, RoundedQuaternionsAreNormalizedQuietly) {
  const std::string text = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0.7071 0.7071\n";
  EXPECT_THAT(WarningsOf(text), IsEmpty());
  EXPECT_NEAR(FileOf<SE3>(text).graph.nodes()[0].pose.rotation().norm(), 1, 1e-15);
}

TEST(OddCases, HugeQuaternionsStayFinite) {
  const GraphFile<SE3> file = FileOf<SE3>("VERTEX_SE3:QUAT 0 1 2 3 0 0 3e300 4e300\n");
  EXPECT_NEAR(file.graph.nodes()[0].pose.rotation().w(), 0.8, 1e-15);
}

TEST(OddCases, ZeroQuaternionIsAnError) {
  EXPECT_EQ(ErrorOf("VERTEX_SE3:QUAT 0 1 2 3 0 0 0 0\n"), "f:1: zero quaternion: '0 0 0 0'");
  EXPECT_EQ(ErrorOf(Two3d("EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1e-30") + kUnit3d),
            "f:3: zero quaternion: '0 0 0 1e-30'");
}

TEST(OddCases, NumbersMustBeFiniteAndDecimal) {
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 nan 0 0\n"), "f:1: VERTEX_SE2: not a finite number: 'nan'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 0 -inf 0\n"), "f:1: VERTEX_SE2: not a finite number: '-inf'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 0 0 0,5\n"), "f:1: VERTEX_SE2: not a number: '0,5'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 0 1e400 0\n"), "f:1: VERTEX_SE2: number out of range: '1e400'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 0 NaN 1 0 1\n")),
            "f:3: EDGE_SE2: not a finite number: 'NaN'");
  EXPECT_EQ(FileOf<SE2>("VERTEX_SE2 0 +1.5 0 0\n").graph.nodes()[0].pose.data()[0], 1.5);
}

TEST(OddCases, ShortMissingAndExtraFieldsAreErrors) {
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 0 0\n")),
            "f:3: EDGE_SE2 needs 11 numbers, has 8: 'EDGE_SE2 0 1 1 0 0 1 0 0'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0\n")),
            "f:3: EDGE_SE2 needs 11 numbers, has 5, the information is missing "
            "(--identity_information takes the identity): 'EDGE_SE2 0 1 1 0 0'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1 7\n")),
            "f:3: EDGE_SE2 needs 11 numbers, has 12: 'EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1 7'");
  EXPECT_EQ(ErrorOf("VERTEX_SE3:QUAT 3\n"),
            "f:1: VERTEX_SE3:QUAT needs 8 numbers, has 1: 'VERTEX_SE3:QUAT 3'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2\n"), "f:1: VERTEX_SE2 needs 4 numbers, has 0: 'VERTEX_SE2'");
}

TEST(OddCases, IndefiniteInformationIsAnErrorOrProjected) {
  const std::string text = Two("EDGE_SE2 0 1 1 0 0 1 0 0 -2 0 4\n");
  EXPECT_EQ(ErrorOf(text),
            "f:3: information is not positive semi-definite, smallest eigenvalue -2 "
            "(--project_information takes the nearest that is): '1 0 0 -2 0 4'");
  ReadOptions options;
  options.project_information = true;
  ReadReport report;
  const Result<AnyGraphFile> file = ReadText(text, options, &report);
  ASSERT_TRUE(file.ok());
  EXPECT_EQ(report.projected_informations, 1);
  EXPECT_THAT(report.warnings,
              ElementsAre("f:3: information is not positive semi-definite, smallest eigenvalue "
                          "-2, projected: '1 0 0 -2 0 4'"));
  const SE2::Matrix& m = std::get<GraphFile<SE2>>(*file).graph.edges()[0].information;
  EXPECT_NEAR(m(0, 0), 1, 1e-12);
  EXPECT_NEAR(m(1, 1), 4e-9, 1e-15);
  EXPECT_NEAR(m(2, 2), 4, 1e-12);
}

// Metres and radians share the matrix: how small an eigenvalue is says nothing beside another
// unit's.
TEST(OddCases, ANegativeWeightIsAnErrorBesideAnyOther) {
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 -1 0 0 -1 0 1e10\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '-1 0 0 -1 0 1e10'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1e10\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '1 2 0 1 0 1e10'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 0 0 1e-9 0 1e10\n")), "");
}

TEST(OddCases, SemiDefiniteInformationIsAccepted) {
  ReadReport report;
  const std::string text =
      Two("EDGE_SE2 0 1 1 0 0 1 1 0 1 0 4\nEDGE_SE2 0 1 1 0 0 0 0 0 0 0 0\n"
          "EDGE_SE2 0 1 1 0 0 1 1 0 1 0 4\n");
  ASSERT_TRUE(ReadText(text, Strict(), &report).ok());
  EXPECT_EQ(report.semidefinite_informations, 3);
  EXPECT_THAT(report.warnings, IsEmpty());
}

TEST(OddCases, IndefiniteInformationOfPriorsIsAnError) {
  EXPECT_EQ(ErrorOf(Two("EDGE_PRIOR_SE2_XY 0 1 2 1 2 1\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '1 2 1'");
  EXPECT_EQ(ErrorOf(Two3d("EDGE_SE3_XYZ_PRIOR 0 0 1 2 3 1 0 0 -1 0 1\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '1 0 0 -1 0 1'");
}

TEST(OddCases, InformationThatOverflowsIsAnError) {
  const std::string text = "EDGE3 0 1 1 2 3 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1e308\n";
  EXPECT_EQ(ErrorOf(text),
            "f:1: information is too large: '1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1e308'");
}

TEST(OddCases, TheErrorNamesTheOrderThatWouldDo) {
  const std::string row_major = "EDGE2 0 1 1 0 0.1 2 0 0 2 0 7\n";
  EXPECT_EQ(
      ErrorOf(row_major),
      "f:1: information is not positive semi-definite, smallest eigenvalue -6.07107 (in "
      "TORO's order xx xy yy tt xt yt; --row_major_edge2 reads it row by row): '2 0 0 2 0 7'");
  ReadOptions options;
  options.edge2_order = Edge2Order::kRowMajor;
  EXPECT_EQ(FileOf<SE2>(row_major, options).graph.edges()[0].information(2, 2), 7);
  EXPECT_EQ(ErrorOf("EDGE2 0 1 1 0 0.1 2 0 2 7 0 0\n", options),
            "f:1: information is not positive semi-definite, smallest eigenvalue -1.23607 (row by "
            "row, as --row_major_edge2 says; in TORO's order it would be): '2 0 2 7 0 0'");
  EXPECT_EQ(ErrorOf("EDGE2 0 1 1 0 0.1 -2 0 2 7 0 0\n"),
            "f:1: information is not positive semi-definite, smallest eigenvalue -2 (in TORO's "
            "order xx xy yy tt xt yt; --project_information takes the nearest that is): "
            "'-2 0 2 7 0 0'");
}

TEST(OddCases, MissingInformationIsAnErrorOrTheIdentity) {
  const std::string text =
      "VERTEX3 0 0 0 0 0 0 0\nVERTEX3 1 1 0 0 0 0 0\nEDGE3 0 1 1 0 0 0 0 0.1\n";
  ReadReport report;
  const Result<AnyGraphFile> refused = ReadText(text, ReadOptions(), &report);
  EXPECT_EQ(refused.status().message(),
            "f:3: EDGE3 needs 29 numbers, has 8, the information is missing "
            "(--identity_information takes the identity): 'EDGE3 0 1 1 0 0 0 0 0.1'");
  EXPECT_THAT(report.warnings, IsEmpty());
  ReadOptions options;
  options.identity_information = true;
  EXPECT_THAT(WarningsOf(text, options),
              ElementsAre("f:3: no information, the identity is taken: 'EDGE3 0 1 1 0 0 0 0 0.1'",
                          "f:3: information of Euler angles turned into that of the quaternion in "
                          "1 line: 'EDGE3'"));
  SE3::Matrix euler = SE3::Matrix::Identity();
  euler.bottomRightCorner<3, 3>() *= 4;
  EXPECT_EQ(FileOf<SE3>(text, options).graph.edges()[0].information, euler);
  for (const char* line : {"EDGE2 0 1 1 0 0\n", "EDGE_SE2 0 1 1 0 0\n", "ODOMETRY 0 1 1 0 0\n"}) {
    EXPECT_EQ(FileOf<SE2>(line, options).graph.edges()[0].information, SE2::Matrix::Identity());
  }
  // The identity is remembered for no other line: these numbers stand in TORO's order.
  EXPECT_NE(ErrorOf("EDGE2 0 1 1 0 0\nEDGE2 1 2 1 0 0 1 0 0 1 0 1\n", options), "");
  EXPECT_EQ(ErrorOf("EDGE2 0 1 1 0\n", options),
            "f:1: EDGE2 needs 11 numbers, has 4: 'EDGE2 0 1 1 0'");
}

TEST(OddCases, FurtherTagsOfPublicFilesAreRead) {
  const GraphFile<SE2> xyt =
      FileOf<SE2>("VERTEX_XYT 0 0 0 0\nVERTEX_XYT 1 1 0 0.5\nEDGE_XYT 0 1 1 0 0 1 0 0 2 0 3\n");
  EXPECT_EQ(xyt.graph.nodes()[1].pose.angle(), 0.5);
  EXPECT_EQ(xyt.graph.edges()[0].information.diagonal(), Eigen::Vector3d(1, 2, 3));
  const std::string isam = "ODOMETRY 0 1 1 0 0.1 2 1 0 3 0 5\nLANDMARK 0 2 1 1 1 0 1\n";
  EXPECT_THAT(WarningsOf(isam),
              ElementsAre("f:1: its numbers are taken as the square root of the information, as "
                          "iSAM writes them, in 1 line: 'ODOMETRY'",
                          "f:2: landmarks are not optimized, 1 line kept as they are: 'LANDMARK'"));
  SE2::Matrix information;
  information << 4, 2, 0, 2, 10, 0, 0, 0, 25;
  EXPECT_EQ(FileOf<SE2>(isam).graph.edges()[0].information, information);
}

TEST(OddCases, LongTagsAreShortened) {
  const std::string error = ErrorOf(Two(std::string(1000000, 'X') + " 1\n"), Strict());
  EXPECT_EQ(error, "f:3: unknown tag: '" + std::string(70, 'X') + "...'");
}

TEST(OddCases, SelfEdgeIsAnError) {
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1\n")),
            "f:3: edge from node 1 to itself: 'EDGE_SE2 1 1 1 0 0 1 0 0 1 0 1'");
}

TEST(OddCases, APriorWithoutItsParameterTakesTheIdentity) {
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

TEST(OddCases, AParameterGivenTwiceMustBeIdentical) {
  const std::string text = Two3d("PARAMS_SE3OFFSET 4 1 2 3 0 0 0 1\nPARAMS_SE3OFFSET 4 1 2 ");
  EXPECT_THAT(WarningsOf(text + "3 0 0 0 1\n"), IsEmpty());
  EXPECT_EQ(ErrorOf(text + "4 0 0 0 1\n"),
            "f:4: parameter 4 was given with another pose: 'PARAMS_SE3OFFSET 4 1 2 4 0 0 0 1'");
}

TEST(OddCases, FilesThatHoldNothingAreErrors) {
  EXPECT_EQ(ErrorOf(""), "f: is empty");
  EXPECT_EQ(ErrorOf("\n# nothing\n"), "f: holds no vertex and no edge");
  EXPECT_EQ(
      ErrorOf("hello world\n"),
      "f: holds no vertex and no edge with a tag that is read; hpgo check --help lists those");
}

TEST(OddCases, UnreadableFilesSayWhy) {
  const Result<AnyGraphFile> missing = ReadG2o("/no/such/file.g2o", ReadOptions(), nullptr);
  EXPECT_EQ(missing.status().code(), StatusCode::kUnreadable);
  EXPECT_EQ(missing.status().message(),
            "/no/such/file.g2o: cannot be opened: No such file or directory");
  const Result<AnyGraphFile> folder = ReadG2o("/", ReadOptions(), nullptr);
  EXPECT_EQ(folder.status().code(), StatusCode::kUnreadable);
  EXPECT_EQ(folder.status().message(), "/: cannot be read: Is a directory");
}

TEST(OddCases, EquivalentNodesAreMerged) {
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

TEST(OddCases, EquivalencesChainAndGiveThePoseThatIsThere) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "EQUIV 7 5\nEQUIV 9 7\nEQUIV 3 9\nVERTEX_SE2 9 1 2 3\nVERTEX_SE2 7 4 5 6\n"
      "VERTEX_SE2 6 0 0 0\nEDGE_SE2 5 6 1 0 0 1 0 0 1 0 1\n");
  ASSERT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_EQ(file.graph.nodes()[0].id, 3);
  EXPECT_EQ(file.graph.nodes()[0].pose.data()[0], 1);
  EXPECT_EQ(file.graph.edges()[0].i, 0);
}

TEST(OddCases, AnEdgeWithinMergedNodesIsKept) {
  const std::string text = Two(std::string(kEdge) + "EQUIV 0 1\n");
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:3: nodes 0 and 1 are one node by EQUIV, the edge is kept as it is: "
                          "'EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1'",
                          "f:4: the nodes it names are one node, 1 line: 'EQUIV'"));
  EXPECT_EQ(FileOf<SE2>(text).graph.edges().size(), 0u);
  EXPECT_EQ(FileOf<SE2>(text).verbatim.size(), 2u);
  EXPECT_EQ(ErrorOf(Two("EQUIV 0\n")), "f:3: EQUIV needs 2 numbers, has 1: 'EQUIV 0'");
}

TEST(OddCases, WarningsOfOneKindAreListedUpToALimit) {
  std::string text;
  for (int k = 0; k < 8; ++k) {
    text += "VERTEX_SE3:QUAT " + std::to_string(k) + " 0 0 0 0 0 0 2\n";
  }
  const std::vector<std::string> warnings = WarningsOf(text);
  ASSERT_EQ(warnings.size(), 6u);
  EXPECT_EQ(warnings[4], "f:5: quaternion of length 2 normalized: '0 0 0 2'");
  EXPECT_EQ(warnings[5], "f: 3 more: quaternions normalized");
  ReadOptions all;
  all.collect_all_problems = true;
  EXPECT_EQ(WarningsOf(text, all).size(), 8u);
}

TEST(OddCases, AllProblemsAreListedInTheOrderOfTheirLines) {
  ReadOptions options;
  options.collect_all_problems = true;
  ReadReport report;
  const Result<AnyGraphFile> file = ReadText(
      "EDGE_SE2 0 9 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 0 0 0 nan\nVERTEX_SE2 1 0 0 0\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 -1 0 1\nEDGE_SE2 1 0 1 0 0 1 0 0 1 0\nEDGE_SE2 1 1 0 0 0 1 0 0 1 0 "
      "1\n"
      "FIX 12\n",
      options, &report);
  EXPECT_EQ(file.status().message(), "f:1: no vertex 9: 'EDGE_SE2 0 9 1 0 0 1 0 0 1 0 1'");
  EXPECT_THAT(report.problems,
              ElementsAre("f:1: no vertex 9: 'EDGE_SE2 0 9 1 0 0 1 0 0 1 0 1'",
                          "f:2: VERTEX_SE2: not a finite number: 'nan'",
                          "f:4: information is not positive semi-definite, smallest eigenvalue -1 "
                          "(--project_information takes the nearest that is): '1 0 0 -1 0 1'",
                          "f:5: EDGE_SE2 needs 11 numbers, has 10: 'EDGE_SE2 1 0 1 0 0 1 0 0 1 0'",
                          "f:6: edge from node 1 to itself: 'EDGE_SE2 1 1 0 0 0 1 0 0 1 0 1'",
                          "f:7: FIX of node 12, which is not there: 'FIX 12'"));
  EXPECT_EQ(report.lines, 7);
}

}  // namespace
}  // namespace hpgo
