// hpgo convert as a shell sees it.
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;

constexpr char kGraph[] =
    "VERTEX_SE2 4 1 2 0\nVERTEX_SE2 1 0.5 0 0\nFIX 1\nEDGE_SE2 1 4 1 0 0 1 0 0 1 0 1\n# end\n";

// Converts `text` from stdin to stdout.
ProgramResult Convert(const std::string& text, std::vector<std::string> flags) {
  ProgramOptions options;
  options.input = text;
  flags.insert(flags.begin(), {"convert", "-", "-"});
  return RunProgram(flags, options);
}

TEST(ConvertCommandTest, GraphsKeepEverything) {
  const ProgramResult result = Convert(kGraph, {"--to=g2o"});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_EQ(result.out, kGraph);
  EXPECT_EQ(result.err, "");
}

TEST(ConvertCommandTest, ToroBecomesG2o) {
  const ProgramResult result =
      Convert("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 10 1 20 30 2 3\n", {"--to=g2o"});
  EXPECT_EQ(result.out,
            "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 10 1 2 20 3 30\n");
}

TEST(ConvertCommandTest, TrajectoriesTakePosesAloneAndSaySo) {
  const ProgramResult tum = Convert(kGraph, {"--to=tum"});
  EXPECT_EQ(tum.exit_code, hpgo_cli::kExitOk);
  EXPECT_EQ(tum.out, "1 0.5 0 0 0 0 0 1\n4 1 2 0 0 0 0 1\n");
  EXPECT_EQ(tum.err,
            "warning: TUM holds poses alone; left out: 1 edge, 0 priors, 1 FIX line, 1 other "
            "line\n"
            "the node ids stand in for the time stamps\n");
  const ProgramResult kitti = Convert(kGraph, {"--to=kitti", "--quiet"});
  EXPECT_EQ(kitti.out, "1 0 0 0.5 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 2 0 0 1 0\n");
}

TEST(ConvertCommandTest, PosesAreComposedWhereThereAreEdgesOnly) {
  const ProgramResult result =
      Convert("EDGE_SE2 0 1 2 0 0 1 0 0 1 0 1\nEDGE_SE2 1 2 0 1 0 1 0 0 1 0 1\n", {"--to=tum"});
  EXPECT_EQ(result.out, "0 0 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n2 2 1 0 0 0 0 1\n");
  EXPECT_EQ(result.err,
            "warning: TUM holds poses alone; left out: 2 edges, 0 priors, 0 FIX lines, 0 other "
            "lines\n"
            "no vertices: poses are composed from the edges\n"
            "the node ids stand in for the time stamps\n");
}

TEST(ConvertCommandTest, TrajectoriesConvertToEachOther) {
  const std::string tum = "1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0.6 0.8\n";
  const ProgramResult kitti = Convert(tum, {"--to=kitti"});
  EXPECT_EQ(kitti.out, "1 0 0 1 0 1 0 2 0 0 1 3\n0.28 -0.96 0 4 0.96 0.28 0 5 0 0 1 6\n");
  EXPECT_EQ(kitti.err, "warning: the time stamps are left out: the output has no place for them\n");
  const ProgramResult g2o = Convert(tum, {"--to=g2o", "--from=tum"});
  EXPECT_EQ(g2o.out, "VERTEX_SE3:QUAT 0 1 2 3 0 0 0 1\nVERTEX_SE3:QUAT 1 4 5 6 0 0 0.6 0.8\n");
}

TEST(ConvertCommandTest, TheExtensionTellsTheFormat) {
  const TemporaryDirectory directory;
  const std::string input = directory.Write("in.g2o", kGraph);
  for (const char* name : {"out.g2o", "out.kitti", "out.txt", "out.tum"}) {
    EXPECT_EQ(RunProgram({"convert", input, directory.File(name)}).exit_code, hpgo_cli::kExitOk);
  }
  EXPECT_EQ(ReadFile(directory.File("out.g2o")), kGraph);
  EXPECT_EQ(ReadFile(directory.File("out.txt")), ReadFile(directory.File("out.kitti")));
  EXPECT_EQ(ReadFile(directory.File("out.tum")), "1 0.5 0 0 0 0 0 1\n4 1 2 0 0 0 0 1\n");
  EXPECT_THAT(directory.List(),
              ElementsAre("in.g2o", "out.g2o", "out.kitti", "out.tum", "out.txt"));
}

TEST(ConvertCommandTest, UsageErrors) {
  EXPECT_EQ(
      Convert(kGraph, {}).err,
      "error: the name - does not tell the format; say --to=g2o, kitti or tum (see --help)\n");
  EXPECT_EQ(Convert(kGraph, {"--to=toro"}).err,
            "error: --to=toro: must be auto, g2o, kitti or tum (see --help)\n");
  const ProgramResult from = Convert(kGraph, {"--to=g2o", "--from=png"});
  EXPECT_EQ(from.exit_code, hpgo_cli::kExitUsage);
  EXPECT_EQ(from.err, "error: --from=png: must be auto, g2o, kitti or tum (see --help)\n");
}

TEST(ConvertCommandTest, FailuresLeaveNothing) {
  const TemporaryDirectory directory;
  const ProgramResult malformed = Convert("VERTEX_SE2 0 0 0 nan\n", {"--to=g2o"});
  EXPECT_EQ(malformed.exit_code, hpgo_cli::kExitMalformed);
  EXPECT_EQ(malformed.out, "");
  EXPECT_EQ(malformed.err, "error: stdin:1: VERTEX_SE2: not a finite number: 'nan'\n");
  EXPECT_EQ(Convert("1 2 3\n", {"--to=g2o"}).err,
            "error: stdin: looks like a table of 3 numbers a line, no graph and no trajectory\n");
  const ProgramResult unwritable =
      RunProgram({"convert", directory.Write("in.g2o", kGraph), directory.File("no/out.g2o")});
  EXPECT_EQ(unwritable.exit_code, hpgo_cli::kExitUnreadable);
  EXPECT_EQ(unwritable.err, "error: " + directory.File("no/out.g2o") +
                                ": cannot be created: No such file or directory\n");
  EXPECT_THAT(directory.List(), ElementsAre("in.g2o"));
}

}  // namespace
}  // namespace hpgo
