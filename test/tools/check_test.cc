// hpgo check as a shell sees it.
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

constexpr char kGood[] =
    "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nVERTEX_XY 9 1 1\nFIX 0\n"
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1 0 0 1 0 0 0 0 1\n";

ProgramResult Check(const std::string& text, std::vector<std::string> flags = {}) {
  ProgramOptions options;
  options.input = text;
  flags.insert(flags.begin(), {"check", "-"});
  return RunProgram(flags, options);
}

TEST(CheckCommandTest, SummarizesAFileThatCanBeUsed) {
  const ProgramResult result = Check(kGood);
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_EQ(result.out,
            "6 lines: EDGE_SE2 2, FIX 1, VERTEX_SE2 2, VERTEX_XY 1\n"
            "2D, 2 nodes (1 fixed), 2 edges (1 loop closure), 0 priors, 1 component\n"
            "1 line of landmarks, kept as text\n"
            "1 information without full rank\n"
            "0 problems, 1 warning\n");
  EXPECT_EQ(result.err,
            "warning: stdin:3: landmarks are not optimized, 1 line kept as they are: "
            "'VERTEX_XY'\n");
}

TEST(CheckCommandTest, ListsEveryProblemWithItsLine) {
  const ProgramResult result =
      Check(std::string(kGood) + "EDGE_SE2 0 5 1 0 0 1 0 0 1 0 1\nVERTEX_SE2 2 0,5 0 0\n");
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitMalformed);
  EXPECT_EQ(result.out,
            "stdin:7: no vertex 5: 'EDGE_SE2 0 5 1 0 0 1 0 0 1 0 1'\n"
            "stdin:8: VERTEX_SE2: not a number: '0,5'\n"
            "8 lines: EDGE_SE2 3, FIX 1, VERTEX_SE2 3, VERTEX_XY 1\n"
            "1 line of landmarks, kept as text\n"
            "1 information without full rank\n"
            "2 problems, 1 warning\n");
}

TEST(CheckCommandTest, StrictTurnsWarningsIntoProblems) {
  const ProgramResult result = Check(kGood, {"--strict"});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitMalformed);
  EXPECT_EQ(result.out.substr(0, result.out.find('\n')),
            "stdin:3: landmarks are not optimized: 'VERTEX_XY'");
  EXPECT_EQ(result.err, "");
}

TEST(CheckCommandTest, ProjectsInformationIfAsked) {
  const std::string text = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 -1\n";
  EXPECT_EQ(Check(text).exit_code, hpgo_cli::kExitMalformed);
  const ProgramResult result = Check(text, {"--project_information"});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_EQ(result.out,
            "1 line: EDGE_SE2 1\n"
            "2D, 2 nodes (0 fixed), 1 edge (0 loop closures), 0 priors, 1 component\n"
            "no vertices: poses are composed from the edges\n"
            "1 information projected\n"
            "0 problems, 1 warning\n");
}

TEST(CheckCommandTest, ReadsEdge2InEitherOrder) {
  const std::string text = "EDGE2 0 1 1 0 0 1 0 0 1 0 1\n";
  EXPECT_EQ(Check(text).exit_code, hpgo_cli::kExitMalformed);
  EXPECT_EQ(Check(text, {"--row_major_edge2"}).exit_code, hpgo_cli::kExitOk);
}

TEST(CheckCommandTest, ListsTheTagsThatAreReadAndThoseThatAreKept) {
  const ProgramResult result = RunProgram({"check", "--help"});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_NE(result.out.find("Tags that are read, in 2D:\n"
                            "  EDGE_SE2 VERTEX_SE2 PARAMS_SE2OFFSET EDGE_PRIOR_SE2 "
                            "EDGE_PRIOR_SE2_XY VERTEX2\n"
                            "  VERTEX EDGE2 EDGE VERTEX_XYT EDGE_XYT ODOMETRY\n"
                            "in 3D:\n"
                            "  EDGE_SE3:QUAT VERTEX_SE3:QUAT PARAMS_SE3OFFSET EDGE_SE3_PRIOR\n"
                            "  EDGE_SE3_XYZ_PRIOR VERTEX3 EDGE3\n"
                            "in both:\n"
                            "  FIX EQUIV\n"
                            "Landmarks, kept as text:\n"
                            "  VERTEX_XY EDGE_SE2_XY VERTEX_TRACKXYZ EDGE_SE3_TRACKXYZ LANDMARK\n"
                            "Any other tag is kept as text.\n"),
            std::string::npos)
      << result.out;
}

TEST(CheckCommandTest, LongTagsAreShortenedAndManyAreCounted) {
  const std::string tag = std::string(70, 'X') + "...";
  const ProgramResult one = Check("VERTEX_SE2 0 0 0 0\n" + std::string(1000000, 'X') + "\n");
  EXPECT_EQ(one.out.substr(0, one.out.find('\n')), "2 lines: VERTEX_SE2 1, " + tag + " 1");
  EXPECT_EQ(one.err, "warning: stdin:2: unknown tag, 1 line kept as they are: '" + tag + "'\n");
  std::string text = "VERTEX_SE2 0 0 0 0\n";
  for (int k = 10; k < 50; ++k) text += "T" + std::to_string(k) + "\n";
  const std::string many = Check(text).out;
  EXPECT_EQ(many.substr(many.find("T39"), 21), "T39 1, 11 other tags\n");
}

TEST(CheckCommandTest, SaysWhatAFileIsThatIsNoGraph) {
  const ProgramResult result = Check("\n#time,px,py\n1,2,3\n");
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitMalformed);
  EXPECT_EQ(result.out,
            "stdin: looks like a table with 3 numbers a line parted by commas; trajectories are "
            "read as TUM: stamp x y z qx qy qz qw, parted by spaces\n"
            "1 problem, 0 warnings\n");
  EXPECT_EQ(result.err, "");
}

TEST(CheckCommandTest, TakesTheIdentityIfAsked) {
  const ProgramResult result = Check("EDGE2 0 1 1 0 0\n", {"--identity_information"});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_EQ(result.out,
            "1 line: EDGE2 1\n"
            "2D, 2 nodes (0 fixed), 1 edge (0 loop closures), 0 priors, 1 component\n"
            "no vertices: poses are composed from the edges\n"
            "1 information missing, the identity taken\n"
            "0 problems, 1 warning\n");
}

TEST(CheckCommandTest, WhatCannotBeReadIsNotMalformed) {
  const ProgramResult result = RunProgram({"check", "/no/such/file.g2o"});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitUnreadable);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "error: /no/such/file.g2o: cannot be opened: No such file or directory\n");
}

}  // namespace
}  // namespace hpgo
