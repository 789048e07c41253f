// Odd numbers of g2o and TORO files, with the exact text of their errors and warnings: fields,
// quaternions, information matrices.

#include <string>

#include "gmock/gmock.h"
#include "test/io/graph_text.h"
#include "test/io/two_nodes.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(OddNumbers, QuaternionsOffUnitAreNormalizedWithAWarning) {
  const std::string text = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1.01\n";
  EXPECT_THAT(WarningsOf(text),
              ElementsAre("f:1: quaternion of length 1.01 normalized: '0 0 0 1.01'"));
  EXPECT_EQ(FileOf<SE3>(text).graph.nodes()[0].pose.rotation().w(), 1);
  EXPECT_EQ(ErrorOf(text, Strict()), "f:1: quaternion of length 1.01 normalized: '0 0 0 1.01'");
  EXPECT_THAT(WarningsOf(Two3d("EDGE_SE3:QUAT 0 1 1 0 0 0 0 3 4").substr(0) + kUnit3d),
              ElementsAre("f:3: quaternion of length 5 normalized: '0 0 3 4'"));
}

TEST(OddNumbers, RoundedQuaternionsAreNormalizedQuietly) {
  const std::string text = "VERTEX_SE3:QUAT 0 1 2 3 0 0 0.7071 0.7071\n";
  EXPECT_THAT(WarningsOf(text), IsEmpty());
  EXPECT_NEAR(FileOf<SE3>(text).graph.nodes()[0].pose.rotation().norm(), 1, 1e-15);
}

TEST(OddNumbers, HugeQuaternionsStayFinite) {
  const GraphFile<SE3> file = FileOf<SE3>("VERTEX_SE3:QUAT 0 1 2 3 0 0 3e300 4e300\n");
  EXPECT_NEAR(file.graph.nodes()[0].pose.rotation().w(), 0.8, 1e-15);
}

TEST(OddNumbers, ZeroQuaternionIsAnError) {
  EXPECT_EQ(ErrorOf("VERTEX_SE3:QUAT 0 1 2 3 0 0 0 0\n"), "f:1: zero quaternion: '0 0 0 0'");
  EXPECT_EQ(ErrorOf(Two3d("EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1e-30") + kUnit3d),
            "f:3: zero quaternion: '0 0 0 1e-30'");
}

TEST(OddNumbers, NumbersMustBeFiniteAndDecimal) {
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 nan 0 0\n"), "f:1: VERTEX_SE2: not a finite number: 'nan'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 0 -inf 0\n"), "f:1: VERTEX_SE2: not a finite number: '-inf'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 0 0 0,5\n"), "f:1: VERTEX_SE2: not a number: '0,5'");
  EXPECT_EQ(ErrorOf("VERTEX_SE2 0 0 1e400 0\n"), "f:1: VERTEX_SE2: number out of range: '1e400'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 0 NaN 1 0 1\n")),
            "f:3: EDGE_SE2: not a finite number: 'NaN'");
  EXPECT_EQ(FileOf<SE2>("VERTEX_SE2 0 +1.5 0 0\n").graph.nodes()[0].pose.data()[0], 1.5);
}

TEST(OddNumbers, ShortMissingAndExtraFieldsAreErrors) {
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

TEST(OddNumbers, IndefiniteInformationIsAnErrorOrProjected) {
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
TEST(OddNumbers, ANegativeWeightIsAnErrorBesideAnyOther) {
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 -1 0 0 -1 0 1e10\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '-1 0 0 -1 0 1e10'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 2 0 1 0 1e10\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '1 2 0 1 0 1e10'");
  EXPECT_EQ(ErrorOf(Two("EDGE_SE2 0 1 1 0 0 1 0 0 1e-9 0 1e10\n")), "");
}

TEST(OddNumbers, SemiDefiniteInformationIsAccepted) {
  ReadReport report;
  const std::string text =
      Two("EDGE_SE2 0 1 1 0 0 1 1 0 1 0 4\nEDGE_SE2 0 1 1 0 0 0 0 0 0 0 0\n"
          "EDGE_SE2 0 1 1 0 0 1 1 0 1 0 4\n");
  ASSERT_TRUE(ReadText(text, Strict(), &report).ok());
  EXPECT_EQ(report.semidefinite_informations, 3);
  EXPECT_THAT(report.warnings, IsEmpty());
}

TEST(OddNumbers, IndefiniteInformationOfPriorsIsAnError) {
  EXPECT_EQ(ErrorOf(Two("EDGE_PRIOR_SE2_XY 0 1 2 1 2 1\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '1 2 1'");
  EXPECT_EQ(ErrorOf(Two3d("EDGE_SE3_XYZ_PRIOR 0 0 1 2 3 1 0 0 -1 0 1\n")),
            "f:3: information is not positive semi-definite, smallest eigenvalue -1 "
            "(--project_information takes the nearest that is): '1 0 0 -1 0 1'");
}

TEST(OddNumbers, InformationThatOverflowsIsAnError) {
  const std::string text = "EDGE3 0 1 1 2 3 0 0 0 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1e308\n";
  EXPECT_EQ(ErrorOf(text),
            "f:1: information is too large: '1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1e308'");
}

TEST(OddNumbers, TheErrorNamesTheOrderThatWouldDo) {
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

TEST(OddNumbers, MissingInformationIsAnErrorOrTheIdentity) {
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

}  // namespace
}  // namespace hpgo
