// hpgo generate as a shell sees it, and the commands in a row.
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

TEST(GenerateCommandTest, EqualSeedsGiveEqualFiles) {
  const std::vector<std::string> arguments = {"generate", "--world=grid", "--nodes=200",
                                              "--output=-", "--seed"};
  const auto run = [&arguments](const std::string& seed) {
    std::vector<std::string> all = arguments;
    all.push_back(seed);
    return RunProgram(all);
  };
  const ProgramResult one = run("1");
  EXPECT_EQ(one.exit_code, hpgo_cli::kExitOk) << one.err;
  EXPECT_THAT(one.out, HasSubstr("VERTEX_SE3:QUAT 199 "));
  EXPECT_EQ(run("1").out, one.out);
  EXPECT_NE(run("2").out, one.out);
}

TEST(GenerateCommandTest, WrongValuesAreUsageErrors) {
  for (const char* flag : {"--world=moon", "--nodes=-1", "--dim=4", "--outliers=2"}) {
    const ProgramResult result = RunProgram({"generate", flag, "--output=-"});
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitUsage) << flag;
    EXPECT_THAT(result.err, StartsWith("error: "));
    EXPECT_EQ(result.out, "");
  }
}

// What the README shows, on a small world.
TEST(PipelineTest, GenerateOptimizeEvaluatePlot) {
  const TemporaryDirectory directory;
  const std::string graph = directory.File("graph.g2o");
  const std::string truth = directory.File("truth.g2o");
  const std::string optimized = directory.File("optimized.g2o");
  const std::string picture = directory.File("picture.svg");
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"generate", "--world=sphere", "--nodes=400", "--noise_rotation=0.05", "--output", graph,
            "--ground_truth", truth},
           {"optimize", graph, "--output", optimized},
           {"check", optimized},
           {"plot", graph, optimized, "--output", picture}}) {
    const ProgramResult result = RunProgram(arguments);
    ASSERT_EQ(result.exit_code, hpgo_cli::kExitOk) << arguments[0] << ": " << result.err;
  }
  EXPECT_THAT(ReadFile(picture), HasSubstr("400 nodes"));

  // Dead reckoning is metres off, the optimum is not: the thresholds tell them apart.
  const std::vector<std::string> thresholds = {"--reference", truth, "--max_ate=0.5"};
  const auto evaluate = [&thresholds](const std::string& estimate) {
    std::vector<std::string> arguments = {"evaluate", estimate};
    arguments.insert(arguments.end(), thresholds.begin(), thresholds.end());
    return RunProgram(arguments);
  };
  const ProgramResult good = evaluate(optimized);
  EXPECT_EQ(good.exit_code, hpgo_cli::kExitOk) << good.out << good.err;
  EXPECT_THAT(good.out, HasSubstr("chi2"));
  EXPECT_THAT(good.out, HasSubstr("ATE"));
  const ProgramResult bad = evaluate(graph);
  EXPECT_EQ(bad.exit_code, hpgo_cli::kExitComparison) << bad.out;
}

}  // namespace
}  // namespace hpgo
