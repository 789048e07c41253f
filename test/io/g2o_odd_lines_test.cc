// Odd lines of g2o and TORO files, with the exact text of their errors and warnings: ends,
// comments, tags.

#include <string>

#include "gmock/gmock.h"
#include "hpgo/io/g2o_writer.h"
#include "test/io/graph_text.h"
#include "test/io/two_nodes.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;

TEST(OddLines, CommentsBlankLinesAndSpacesAreSkipped) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "# comment\n\n  \t\n  # another\n VERTEX_SE2  0\t0 0 0  \n\nVERTEX_SE2 1 1 0 0 # first\n");
  EXPECT_EQ(file.graph.nodes().size(), 2u);
  EXPECT_THAT(file.verbatim, ElementsAre("# comment", "  # another"));
}

TEST(OddLines, CarriageReturnsAreSkipped) {
  const GraphFile<SE2> file = FileOf<SE2>(
      "VERTEX_SE2 0 0 0 0\r\n\r\nVERTEX_SE2 1 1 0 0.5\r\nEDGE_SE2 0 1 1 0 0 1 0 0 1 0 2\r\n");
  EXPECT_EQ(file.graph.nodes()[1].pose.angle(), 0.5);
  EXPECT_EQ(file.graph.edges()[0].information(2, 2), 2);
}

TEST(OddLines, CarriageReturnsOfKeptLinesStay) {
  const std::string text = "VERTEX_SE2 0 0 0 0\n# note\r\r\n# one\r\nTAG 1\r\r\r\n";
  const GraphFile<SE2> file = FileOf<SE2>(text);
  EXPECT_THAT(file.verbatim, ElementsAre("# note\r\r", "# one", "TAG 1\r\r\r"));
  std::string written;
  ASSERT_TRUE(FormatG2o(file, WriteOptions(), &written).ok());
  EXPECT_EQ(written, "VERTEX_SE2 0 0 0 0\n# note\r\r\n# one\nTAG 1\r\r\r\n");
  EXPECT_EQ(FileOf<SE2>(written).verbatim, file.verbatim);
}

TEST(OddLines, ByteOrderMarkIsStripped) {
  const GraphFile<SE2> file = FileOf<SE2>("\xEF\xBB\xBFVERTEX_SE2 7 1 2 3\n");
  EXPECT_EQ(file.graph.nodes()[0].id, 7);
}

TEST(OddLines, LastLineNeedsNoEnd) {
  EXPECT_EQ(FileOf<SE2>("VERTEX_SE2 7 1 2 3").graph.nodes()[0].pose.angle(), 3);
}

TEST(OddLines, UnknownTagsAreKeptWithOneWarningEach) {
  const std::string text = Two("VERTEX_CAM 4 1 2 3\nROBOTLASER1 0 1\nVERTEX_CAM 5 nan\n") + kEdge;
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:3: unknown tag, 2 lines kept as they are: 'VERTEX_CAM'",
                          "f:4: unknown tag, 1 line kept as they are: 'ROBOTLASER1'"));
  EXPECT_THAT(FileOf<SE2>(text).verbatim,
              ElementsAre("VERTEX_CAM 4 1 2 3", "ROBOTLASER1 0 1", "VERTEX_CAM 5 nan"));
  EXPECT_EQ(ErrorOf(text, Strict()), "f:3: unknown tag: 'VERTEX_CAM'");
}

TEST(OddLines, TagsAreCaseSensitive) {
  EXPECT_EQ(ErrorOf(Two("edge_se2 0 1\n"), Strict()), "f:3: unknown tag: 'edge_se2'");
}

TEST(OddLines, LandmarksAreCountedAndKept) {
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

TEST(OddLines, FurtherTagsOfPublicFilesAreRead) {
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

TEST(OddLines, LongTagsAreShortened) {
  const std::string error = ErrorOf(Two(std::string(1000000, 'X') + " 1\n"), Strict());
  EXPECT_EQ(error, "f:3: unknown tag: '" + std::string(70, 'X') + "...'");
}

TEST(OddLines, FilesThatHoldNothingAreErrors) {
  EXPECT_EQ(ErrorOf(""), "f: is empty");
  EXPECT_EQ(ErrorOf("\n# nothing\n"), "f: holds no vertex and no edge");
  EXPECT_EQ(
      ErrorOf("hello world\n"),
      "f: holds no vertex and no edge with a tag that is read; hpgo check --help lists those");
}

TEST(OddLines, UnreadableFilesSayWhy) {
  const Result<AnyGraphFile> missing = ReadG2o("/no/such/file.g2o", ReadOptions(), nullptr);
  EXPECT_EQ(missing.status().code(), StatusCode::kUnreadable);
  EXPECT_EQ(missing.status().message(),
            "/no/such/file.g2o: cannot be opened: No such file or directory");
  const Result<AnyGraphFile> folder = ReadG2o("/", ReadOptions(), nullptr);
  EXPECT_EQ(folder.status().code(), StatusCode::kUnreadable);
  EXPECT_EQ(folder.status().message(), "/: cannot be read: Is a directory");
}

TEST(OddLines, WarningsOfOneKindAreListedUpToALimit) {
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

TEST(OddLines, AllProblemsAreListedInTheOrderOfTheirLines) {
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
