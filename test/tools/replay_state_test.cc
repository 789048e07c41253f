// hpgo replay: saved states.

#include <sstream>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/replay_fixture.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitMalformed;
using hpgo_cli::kExitOk;
using hpgo_cli::kExitUsage;
using nlohmann::json;
using ::testing::HasSubstr;

class ReplayStateTest : public ReplayFixture {};

// The nodes below `end` with the edges between them.
std::string FirstNodes(const std::string& graph, int end) {
  std::string first;
  for (const std::string& line : Lines(graph)) {
    std::istringstream fields(line);
    std::string tag;
    int i = 0, j = 0;
    fields >> tag >> i >> j;
    const bool is_edge = tag.compare(0, 4, "EDGE") == 0;
    if (i < end && (!is_edge || j < end)) first += line + "\n";
  }
  return first;
}

TEST_F(ReplayStateTest, ResumesWithTheSameBits) {
  const std::string graph = Generate({"--world=city", "--nodes=600", "--seed=4"});
  const std::string first = directory_.Write("first.g2o", FirstNodes(ReadFile(graph), 350));
  const std::string state = directory_.File("state");
  const std::string whole = directory_.File("whole.g2o"), resumed = directory_.File("resumed.g2o");
  ProgramResult result =
      RunProgram({"replay", graph, "--quiet", "--max_top_nodes=20", "--output=" + whole});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  result = RunProgram(
      {"replay", first, "--quiet", "--max_top_nodes=20", "--save=" + state, "--save_every=100"});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  result = RunProgram({"replay", graph, "--resume=" + state, "--output=" + resumed});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_THAT(result.err, HasSubstr("resumed " + state + " at 350 nodes"));
  EXPECT_TRUE(ReadFile(resumed) == ReadFile(whole));
  // Of the comparisons, those behind it.
  const json figures = Replay(graph, {"--resume=" + state, "--compare_full=25,50,75,100"});
  ASSERT_EQ(figures["comparisons"].size(), 2u);
  EXPECT_EQ(figures["comparisons"][0]["percent"], 75);
}

TEST_F(ReplayStateTest, RefusesStatesThatDoNotFit) {
  const std::string graph = Generate({"--world=city", "--nodes=100", "--seed=4"});
  const std::string other = Generate({"--world=city", "--nodes=50", "--seed=9"}, "other.g2o");
  const std::string state = directory_.File("state");
  ASSERT_EQ(RunProgram({"replay", graph, "--quiet", "--save=" + state}).exit_code, kExitOk);
  ProgramResult result = RunProgram({"replay", other, "--quiet", "--resume=" + state});
  EXPECT_EQ(result.exit_code, kExitUsage);
  EXPECT_THAT(result.err, HasSubstr("is not of this graph's first nodes"));
  result = RunProgram({"replay", graph, "--quiet", "--preset=fast", "--resume=" + state});
  EXPECT_EQ(result.exit_code, kExitUsage);
  EXPECT_THAT(result.err, HasSubstr("--preset=fast: the options of the state are others"));
  result = RunProgram({"replay", graph, "--quiet", "--preset=accurate", "--resume=" + state});
  EXPECT_EQ(result.exit_code, kExitOk) << result.err;
  result = RunProgram({"replay", graph, "--quiet", "--resume=" + graph});
  EXPECT_EQ(result.exit_code, kExitMalformed);
  EXPECT_EQ(result.err, "error: " + graph + ": is no saved state\n");
  result = RunProgram({"replay", graph, "--save_every=5"});
  EXPECT_EQ(result.exit_code, kExitUsage);
  EXPECT_THAT(result.err, HasSubstr("--save_every needs --save"));
  for (const char* flag : {"--compare_at=closures", "--stale_poses=2"}) {
    result = RunProgram({"replay", graph, "--quiet", "--resume=" + state, flag});
    EXPECT_EQ(result.exit_code, kExitUsage);
    EXPECT_THAT(result.err, HasSubstr("does not go with --resume")) << flag;
  }
}

}  // namespace
}  // namespace hpgo
