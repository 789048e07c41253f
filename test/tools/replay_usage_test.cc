// hpgo replay: wrong flags, the progress line, Ctrl-C.

#include <csignal>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/replay_fixture.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitInterrupted;
using hpgo_cli::kExitUsage;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

class ReplayUsageTest : public ReplayFixture {};

TEST_F(ReplayUsageTest, TheProgressLineIsForTerminals) {
  ProgramOptions options;
  options.input = kChain;
  EXPECT_THAT(RunProgram({"replay", "-"}, options).err, Not(HasSubstr("\r")));
  options.stderr_is_terminal = true;
  options.environment = {"TERM=xterm"};
  EXPECT_THAT(RunProgram({"replay", "-"}, options).err, HasSubstr("1 of 3 nodes, "));
  EXPECT_THAT(RunProgram({"replay", "-", "--quiet"}, options).err, IsEmpty());
}

TEST_F(ReplayUsageTest, CtrlCWritesWhatThereIs) {
  const std::string output = directory_.File("out.g2o"), csv = directory_.File("u.csv");
  ProgramOptions options;
  options.input = kChain;
  options.signal = SIGINT;
  // Interrupted while it waits for its input: no node arrives.
  const ProgramResult result = RunProgram(
      {"replay", "-", "--output=" + output, "--stats_csv=" + csv, "--stats_json=-"}, options);
  EXPECT_EQ(result.exit_code, kExitInterrupted) << result.err;
  EXPECT_THAT(result.err, HasSubstr("interrupted after 0 nodes; the result is of those"));
  EXPECT_EQ(ReadFile(csv), "update,nodes,edges,latency_us,windows,solved_nodes,levels,chi2\n");
  EXPECT_EQ(json::parse(result.out).at("interrupted"), true);
  EXPECT_THAT(directory_.List(), ElementsAre("out.g2o", "u.csv"));
}

TEST_F(ReplayUsageTest, WrongValuesAreUsageErrors) {
  for (const char* flag : {"--solve_every=0",
                           "--solve_every=often",
                           "--mode=half",
                           "--preset=best",
                           "--engine=steam",
                           "--window_nodes=-1",
                           "--max_windows=-2",
                           "--update_seconds=-1",
                           "--loss=total",
                           "--stats_from=1",
                           "--measure_mode=none",
                           "--measure_updates=0",
                           "--chi2_every=-1",
                           "--compare_full=0",
                           "--compare_full=10,x",
                           "--compare_full=101",
                           "--error=big",
                           "--summary_csv=-",
                           "--compare_threshold=1",
                           "--compare_at=loops",
                           "--compare_at=closures:",
                           "--compare_at=closures:0",
                           "--compare_at=closures:2x",
                           "--update_at=never",
                           "--stale_poses=-1",
                           "--chart=gaps.svg"}) {
    const ProgramResult result = RunProgram({"replay", "a.g2o", flag});
    EXPECT_EQ(result.exit_code, kExitUsage) << flag;
    EXPECT_THAT(result.err, StartsWith("error: --")) << flag;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_EQ(
      RunProgram({"replay", "a.g2o", "--output=-", "--stats_csv=-"}).err,
      "error: only one of --output, --stats_csv, --stats_json and --chart can be the standard "
      "output (see --help)\n");
  EXPECT_THAT(RunProgram({"replay", "a.g2o", "--max_windows=-2"}).err,
              StartsWith("error: --max_windows is -2, and must be at least 1"));
}

}  // namespace
}  // namespace hpgo
