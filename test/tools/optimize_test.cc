// hpgo optimize as a shell sees it: exit codes, streams, files, Ctrl-C.
#include <cmath>
#include <csignal>
#include <cstdio>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

// Odometry says 2 m, the closure 2.3 m: the three edges share the difference, chi2 = 3 * 0.1^2.
constexpr char kChain[] =
    "VERTEX_SE2 0 0 0 0\n"
    "VERTEX_SE2 1 1.5 0.5 0\n"
    "VERTEX_SE2 2 2 0 0\n"
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 0 2 2.3 0 0 1 0 0 1 0 1\n";

TEST(OptimizeCommandTest, OptimizesAFile) {
  const TemporaryDirectory directory;
  const std::string input = directory.Write("in.g2o", kChain);
  const std::string output = directory.File("out.g2o");
  const std::string stats = directory.File("stats.json");
  const ProgramResult result =
      RunProgram({"optimize", input, "--output=" + output, "--stats_json=" + stats});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr("read " + input + ": 2D, 3 nodes, 3 edges"));
  EXPECT_THAT(result.err, HasSubstr("-> 0.030000 (sum of e' Omega e, g2o error)"));
  EXPECT_THAT(ReadFile(output), HasSubstr("EDGE_SE2 0 2 2.3 0 0 1 0 0 1 0 1\n"));
  const auto json = nlohmann::json::parse(ReadFile(stats));
  EXPECT_EQ(json.at("exit_code"), 0);
  EXPECT_NEAR(json.at("chi2_after").get<double>(), 0.03, 1e-9);
  // Nothing but what was asked for is left behind.
  EXPECT_THAT(directory.List(), ElementsAre("in.g2o", "out.g2o", "stats.json"));
}

// No edge measures a rotation: chi2 0 is reached in many ways, and that is said.
TEST(OptimizeCommandTest, NodesThatNothingDeterminesAreNamed) {
  const TemporaryDirectory directory;
  const std::string stats = directory.File("stats.json");
  ProgramOptions options;
  options.input =
      "VERTEX_SE2 0 0 0 0\nFIX 0\nVERTEX_SE2 1 2 3.1 0\n"
      "VERTEX_SE2 2 1.9 5 0\nVERTEX_SE2 3 6 7 0\n"
      "EDGE_SE2 0 1 2 3 0 4 0 0 4 0 0\nEDGE_SE2 1 2 0 2 0 4 0 0 4 0 0\n"
      "EDGE_SE2 2 3 4 2 0 4 0 0 4 0 0\nEDGE_SE2 3 0 -6.5 7.2 0 4 0 0 4 0 0\n";
  for (const char* engine : {"--engine=block", "--engine=ceres"}) {
    const ProgramResult result =
        RunProgram({"optimize", "-", engine, "--stats_json=" + stats}, options);
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
    EXPECT_THAT(result.err,
                HasSubstr("warning: 3 nodes are not determined, the first of them 1: "));
    const auto json = nlohmann::json::parse(ReadFile(stats));
    EXPECT_EQ(json.at("undetermined_nodes"), 3);
    EXPECT_EQ(json.at("first_undetermined_node"), 1);
  }
}

// Two edges of rank one: what they leave open stays where it is, within what the rest moves it.
TEST(OptimizeCommandTest, DirectionsThatNothingMeasuresDoNotRunAway) {
  ProgramOptions options;
  options.input =
      "VERTEX_SE2 0 0 0 0\n"
      "VERTEX_SE2 1 0.6656 -0.7062 -0.3825\n"
      "VERTEX_SE2 2 0.7791 -1.8584 0.0266\n"
      "EDGE_SE2 0 1 0.6656 -0.7062 -0.3825 0 0 0 100 0 0\n"
      "EDGE_SE2 1 2 0.5353 -1.0265 0.4091 100 0 0 0 0 100\n"
      "EDGE_SE2 0 2 0.8069 -1.8383 -0.0213 100 0 0 0 0 100\n";
  for (const char* engine : {"--engine=block", "--engine=ceres"}) {
    for (const char* init : {"--init=file", "--init=odometry"}) {
      const ProgramResult result =
          RunProgram({"optimize", "-", engine, init, "--output=-"}, options);
      EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
      EXPECT_THAT(result.err, HasSubstr("warning: node 2 is not determined: "));
      double x = 0, y = 0;
      const std::size_t line = result.out.find("VERTEX_SE2 2 ");
      ASSERT_NE(line, std::string::npos);
      ASSERT_EQ(std::sscanf(result.out.c_str() + line, "VERTEX_SE2 2 %lf %lf", &x, &y), 2);
      EXPECT_LT(std::hypot(x - 0.78, y + 1.86), 1) << engine << init << ": " << x << ", " << y;
    }
  }
}

TEST(OptimizeCommandTest, QuietSaysNothing) {
  ProgramOptions options;
  options.input = kChain;
  const ProgramResult result = RunProgram({"optimize", "-", "--quiet"}, options);
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
}

TEST(OptimizeCommandTest, StdoutHoldsTheGraphAlone) {
  ProgramOptions options;
  options.input = kChain;
  const ProgramResult result =
      RunProgram({"optimize", "-", "--output=-", "--edge_report"}, options);
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk);
  EXPECT_THAT(result.out, StartsWith("VERTEX_SE2 0 0 0 0\n"));
  options.input = result.out;
  const ProgramResult again = RunProgram({"optimize", "-", "--output=-"}, options);
  EXPECT_THAT(again.err, HasSubstr("chi2 0.030000 -> 0.030000"));
}

TEST(OptimizeCommandTest, TheProgressLineIsForTerminals) {
  if (!HasTerminals()) GTEST_SKIP() << "no pseudo-terminals here";
  ProgramOptions options;
  options.input = kChain;
  EXPECT_THAT(RunProgram({"optimize", "-"}, options).err, Not(HasSubstr("\r")));
  options.stderr_is_terminal = true;
  options.environment = {"TERM=xterm"};
  EXPECT_THAT(RunProgram({"optimize", "-", "--init=file"}, options).err,
              HasSubstr("\r\033[Kiteration 1, cost "));
  EXPECT_THAT(RunProgram({"optimize", "-", "--quiet"}, options).err, IsEmpty());
}

TEST(OptimizeCommandTest, ALimitStillWritesTheResult) {
  const TemporaryDirectory directory;
  const std::string input = directory.Write("in.g2o", kChain);
  const std::string output = directory.File("out.g2o");
  const ProgramResult result =
      RunProgram({"optimize", input, "--max_iterations=0", "--init=file", "--output=" + output});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitLimit);
  EXPECT_THAT(result.err, HasSubstr("a limit ended the optimization before it converged"));
  EXPECT_EQ(ReadFile(output), kChain);
}

TEST(OptimizeCommandTest, CtrlCOnceWritesWhatThereIs) {
  const TemporaryDirectory directory;
  const std::string output = directory.File("out.g2o");
  for (const int signal : {SIGINT, SIGTERM}) {
    ProgramOptions options;
    options.input = kChain;
    options.signal = signal;
    const ProgramResult result =
        RunProgram({"optimize", "-", "--init=file", "--output=" + output}, options);
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitInterrupted);
    EXPECT_THAT(result.err, HasSubstr("interrupted: finishing; press Ctrl-C again to stop"));
    EXPECT_THAT(ReadFile(output), HasSubstr("EDGE_SE2 0 2 2.3 0 0 1 0 0 1 0 1\n"));
  }
}

TEST(OptimizeCommandTest, CtrlCTwiceStops) {
  const TemporaryDirectory directory;
  ProgramOptions options;
  options.input = kChain;
  options.signal = SIGINT;
  options.signal_count = 2;
  const ProgramResult result =
      RunProgram({"optimize", "-", "--output=" + directory.File("out.g2o")}, options);
  EXPECT_EQ(result.exit_code, 128 + SIGINT);
  EXPECT_THAT(directory.List(), IsEmpty());
}

TEST(OptimizeCommandTest, WrongValuesAreUsageErrors) {
  for (const char* flag : {"--init=nowhere", "--engine=steam", "--error=big", "--loss=total",
                           "--loss_on=odd", "--max_iterations=-1", "--max_seconds=-1"}) {
    const ProgramResult result = RunProgram({"optimize", "a.g2o", flag});
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitUsage) << flag;
    EXPECT_THAT(result.err, StartsWith("error: --"));
    EXPECT_EQ(result.out, "");
  }
}

TEST(OptimizeCommandTest, MalformedInputLeavesTheOutputAsItWas) {
  const TemporaryDirectory directory;
  const std::string input =
      directory.Write("in.g2o", std::string(kChain) + "EDGE_SE2 0 1 1 0 nan 1 0 0 1 0 1\n");
  const std::string output = directory.Write("out.g2o", "precious\n");
  const ProgramResult result = RunProgram({"optimize", input, "--output=" + output});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitMalformed);
  EXPECT_THAT(result.err, HasSubstr("error: " + input + ":7: "));
  EXPECT_EQ(ReadFile(output), "precious\n");
}

TEST(OptimizeCommandTest, AnOutputThatCannotBeWrittenIsAnError) {
  ProgramOptions options;
  options.input = kChain;
  for (const char* output : {"/nonexistent/out.g2o", "/dev/full"}) {
    const ProgramResult result =
        RunProgram({"optimize", "-", std::string("--output=") + output}, options);
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitUnreadable) << output;
    EXPECT_THAT(result.err, HasSubstr(std::string("error: ") + output));
  }
}

}  // namespace
}  // namespace hpgo
