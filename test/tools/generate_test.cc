// `hpgo generate`: the files it writes and what it refuses.
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitOk;
using hpgo_cli::kExitUnreadable;
using hpgo_cli::kExitUsage;
using ::testing::HasSubstr;
using ::testing::StartsWith;

int Count(const std::string& text, const std::string& tag) {
  int count = 0;
  for (std::size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at + 1)) {
    ++count;
  }
  return count;
}

TEST(GenerateCommandTest, WritesTheGraphAndTheTruth) {
  const TemporaryDirectory directory;
  const std::string graph = directory.File("g.g2o"), truth = directory.File("t.g2o");
  const ProgramResult result = RunProgram({"generate", "--world=manhattan", "--nodes=500",
                                           "--output=" + graph, "--ground_truth=" + truth});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, StartsWith("manhattan 3D: 500 nodes, "));
  EXPECT_THAT(result.err, HasSubstr(" 0 of them wrong"));
  EXPECT_EQ(Count(ReadFile(graph), "VERTEX_SE3:QUAT"), 500);
  EXPECT_GT(Count(ReadFile(graph), "EDGE_SE3:QUAT"), 700);
  EXPECT_EQ(Count(ReadFile(truth), "VERTEX_SE3:QUAT"), 500);
  EXPECT_EQ(Count(ReadFile(truth), "EDGE"), 0);
}

TEST(GenerateCommandTest, TheSeedDecides) {
  const std::vector<std::string> arguments = {"generate", "--world=city",       "--nodes=200",
                                              "--dim=2",  "--output=-",         "--outliers=0.1",
                                              "--quiet",  "--dense_information"};
  const ProgramResult first = RunProgram(arguments);
  ASSERT_EQ(first.exit_code, kExitOk) << first.err;
  EXPECT_EQ(Count(first.out, "VERTEX_SE2"), 200);
  EXPECT_EQ(first.out, RunProgram(arguments).out);
  std::vector<std::string> other = arguments;
  other.push_back("--seed=2");
  EXPECT_NE(first.out, RunProgram(other).out);
}

TEST(GenerateCommandTest, FollowsATrajectoryAndWritesTumAndKitti) {
  const TemporaryDirectory directory;
  const std::string tum = directory.Write("in.tum",
                                          "0.0 5 5 5 0 0 0 1\n"
                                          "0.5 6 5 5 0 0 0 1\n"
                                          "1.0 7 5 5 0 0 0 1\n");
  const ProgramResult three =
      RunProgram({"generate", "--world=trajectory", "--trajectory=" + tum, "--output=-",
                  "--ground_truth=" + directory.File("t.tum")});
  ASSERT_EQ(three.exit_code, kExitOk) << three.err;
  EXPECT_EQ(Count(three.out, "EDGE_SE3:QUAT"), 2);
  EXPECT_EQ(ReadFile(directory.File("t.tum")),
            "0 0 0 0 0 0 0 1\n1 1 0 0 0 0 0 1\n2 2 0 0 0 0 0 1\n");

  const ProgramResult two =
      RunProgram({"generate", "--world=trajectory", "--trajectory=" + tum, "--nodes=2", "--dim=2",
                  "--plane=xy", "--output=-", "--ground_truth=" + directory.File("t.txt")});
  ASSERT_EQ(two.exit_code, kExitOk) << two.err;
  EXPECT_EQ(Count(two.out, "EDGE_SE2"), 1);
  EXPECT_EQ(ReadFile(directory.File("t.txt")),
            "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 1 0 1 0 0 0 0 1 0\n");

  EXPECT_EQ(
      RunProgram({"generate", "--world=trajectory", "--trajectory=" + tum, "--dim=2", "--output=-"})
          .err,
      "error: " + tum +
          " is 3D: seen in 2D it needs --plane=xy (z up) or --plane=xz (a camera's frame, as "
          "KITTI's) (see --help)\n");
  EXPECT_EQ(RunProgram({"generate", "--world=trajectory", "--trajectory=" + tum, "--nodes=4",
                        "--output=-"})
                .err,
            "error: --nodes=4: " + tum + " has only 3 poses (see --help)\n");
}

TEST(GenerateCommandTest, RefusesWhatIsWrong) {
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases = {
      {{"--world=moon", "--output=-"},
       "--world: no world \"moon\"; there are sphere, torus, grid, manhattan, city, trajectory"},
      {{"--world=sphere", "--dim=2", "--output=-"}, "the sphere is a 3D world"},
      {{"--dim=4", "--output=-"}, "--dim=4: must be 2 or 3"},
      {{"--nodes=-1", "--output=-"}, "--nodes=-1: must not be negative"},
      {{"--outliers=2", "--output=-"}, "outliers: not a share between 0 and 1"},
      {{"--noise_rotation=nan", "--output=-"}, "rotation noise: not a finite number >= 0"},
      {{"--world=trajectory", "--output=-"},
       "--world=trajectory and --trajectory=FILE belong together"},
      {{"--output=-", "--ground_truth=-"}, "--output and --ground_truth cannot be the same file"},
      {{}, "--output=FILE says where to write the graph"},
  };
  for (const auto& [flags, message] : cases) {
    std::vector<std::string> arguments = {"generate"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, kExitUsage) << message;
    EXPECT_EQ(result.out, "");
    EXPECT_EQ(result.err, "error: " + message + " (see --help)\n");
  }
  const ProgramResult missing =
      RunProgram({"generate", "--world=trajectory", "--trajectory=/nonexistent", "--output=-"});
  EXPECT_EQ(missing.exit_code, kExitUnreadable);
}

}  // namespace
}  // namespace hpgo
