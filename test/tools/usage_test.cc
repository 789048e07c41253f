// Help, usage errors, streams and colours, without solving anything.
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitMalformed;
using hpgo_cli::kExitOk;
using hpgo_cli::kExitUnreadable;
using hpgo_cli::kExitUsage;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kSquare[] =
    "VERTEX_SE2 0 0 0 0\n"
    "VERTEX_SE2 1 1 0 0\n"
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";

void ExpectUsageError(const std::vector<std::string>& arguments, const std::string& message) {
  const ProgramResult result = RunProgram(arguments);
  EXPECT_EQ(result.exit_code, kExitUsage);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "error: " + message + "\n");
}

TEST(HelpTest, TheProgramListsItsCommands) {
  for (const char* flag : {"--help", "-h", "help"}) {
    const ProgramResult result = RunProgram({flag});
    EXPECT_EQ(result.exit_code, kExitOk);
    EXPECT_EQ(result.err, "");
    EXPECT_THAT(result.out, StartsWith("Usage: hpgo COMMAND"));
    EXPECT_THAT(result.out, HasSubstr("\n  plot "));
    EXPECT_THAT(result.out, HasSubstr("130 interrupted"));
  }
}

TEST(HelpTest, NoArgumentsIsAUsageErrorWithTheHelpOnStderr) {
  const ProgramResult result = RunProgram({});
  EXPECT_EQ(result.exit_code, kExitUsage);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, StartsWith("Usage: hpgo COMMAND"));
}

TEST(HelpTest, TheVersionIsThatOfTheProject) {
  const ProgramResult result = RunProgram({"--version"});
  EXPECT_EQ(result.exit_code, kExitOk);
  EXPECT_EQ(result.out, "hpgo " HPGO_VERSION "\n");
}

class CommandHelpTest : public ::testing::TestWithParam<const char*> {};

TEST_P(CommandHelpTest, ShowsUsageAndItsOwnFlagsOnly) {
  const ProgramResult result = RunProgram({GetParam(), "--help"});
  EXPECT_EQ(result.exit_code, kExitOk);
  EXPECT_EQ(result.err, "");
  EXPECT_THAT(result.out, StartsWith(std::string("Usage: hpgo ") + GetParam()));
  EXPECT_THAT(result.out, HasSubstr("\n  --quiet\n"));
  for (const char* foreign : {"flagfile", "logtostderr", "vmodule=", "--tryfromenv"}) {
    EXPECT_THAT(result.out, Not(HasSubstr(foreign)));
  }
  EXPECT_EQ(RunProgram({"help", GetParam()}).out, result.out);
  EXPECT_EQ(RunProgram({GetParam(), "-h"}).out, result.out);
}

INSTANTIATE_TEST_SUITE_P(AllCommands, CommandHelpTest, ::testing::Values(HPGO_COMMANDS),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(UsageTest, NamesWhatIsWrong) {
  ExpectUsageError({"frobnicate"}, "no command 'frobnicate'; hpgo --help lists them");
  ExpectUsageError({"--quiet"}, "no command '--quiet'; hpgo --help lists them");
  const std::string see = "; see hpgo plot --help";
  ExpectUsageError({"plot", "a", "--frobnicate=1"}, "hpgo plot has no flag --frobnicate" + see);
  ExpectUsageError({"plot", "a", "--seed=1"}, "hpgo plot has no flag --seed" + see);
  ExpectUsageError({"plot", "a", "--logtostderr"}, "hpgo plot has no flag --logtostderr" + see);
  ExpectUsageError({"plot", "a", "--width=1x"}, "--width: '1x' is not a valid value (int32)" + see);
  ExpectUsageError({"plot", "a", "--width"}, "--width needs a value" + see);
  ExpectUsageError({"plot"}, "hpgo plot takes INPUT [OTHER], but 0 arguments were given" + see);
  ExpectUsageError({"plot", "a", "b", "c"},
                   "hpgo plot takes INPUT [OTHER], but 3 arguments were given" + see);
}

TEST(PlotCommandTest, WritesAFileAndSaysSoOnStderr) {
  const TemporaryDirectory directory;
  const std::string input = directory.Write("in.g2o", kSquare);
  const std::string output = directory.File("out.svg");
  const ProgramResult result = RunProgram({"plot", input, "--output", output, "--title=A title"});
  EXPECT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, StartsWith("wrote " + output + " ("));
  EXPECT_THAT(ReadFile(output), HasSubstr("2 nodes, 1 edge, 0 loop closures, chi2 0</text>"));
  EXPECT_THAT(ReadFile(output), HasSubstr("A title"));
}

TEST(PlotCommandTest, QuietSaysNothing) {
  const TemporaryDirectory directory;
  const std::string input = directory.Write("in.g2o", kSquare);
  const ProgramResult result =
      RunProgram({"plot", "--quiet", input, "--output=" + directory.File("out.svg")});
  EXPECT_EQ(result.exit_code, kExitOk);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "");
}

TEST(PlotCommandTest, ReadsStdinAndWritesStdout) {
  ProgramOptions options;
  options.input = kSquare;
  const ProgramResult result = RunProgram({"plot", "-", "--output=-"}, options);
  EXPECT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_THAT(result.out, StartsWith("<svg"));
  EXPECT_EQ(result.err, "");
}

TEST(PlotCommandTest, ComposesPosesThatTheFileDoesNotGive) {
  ProgramOptions options;
  options.input = "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n";
  EXPECT_EQ(RunProgram({"plot", "-", "--output=-"}, options).exit_code, kExitOk);
}

TEST(PlotCommandTest, UsageErrors) {
  ExpectUsageError({"plot", "a"}, "--output=FILE.svg is required (see --help)");
  ExpectUsageError({"plot", "-", "-", "--output=x"},
                   "the standard input can be read only once (see --help)");
}

TEST(PlotCommandTest, AMissingFileIsUnreadable) {
  const ProgramResult result = RunProgram({"plot", "/nonexistent.g2o", "--output=-"});
  EXPECT_EQ(result.exit_code, kExitUnreadable);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, StartsWith("error: /nonexistent.g2o: "));
}

TEST(PlotCommandTest, AMalformedFileNamesTheLineAndLeavesNoOutput) {
  const TemporaryDirectory directory;
  const std::string input = directory.Write("in.g2o", "VERTEX_SE2 0 0 zero 0\n");
  const ProgramResult result = RunProgram({"plot", input, "--output=" + directory.File("out.svg")});
  EXPECT_EQ(result.exit_code, kExitMalformed);
  EXPECT_THAT(result.err, StartsWith("error: " + input + ":1: "));
  EXPECT_THAT(result.err, HasSubstr("zero"));
  EXPECT_THAT(directory.List(), ::testing::ElementsAre("in.g2o"));
}

TEST(StreamTest, AFullDiskIsNoSuccess) {
  ProgramOptions options;
  options.input = kSquare;
  options.stdout_path = "/dev/full";
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"plot", "-", "--output=-"}, {"--version"}, {"plot", "--help"}}) {
    const ProgramResult result = RunProgram(arguments, options);
    EXPECT_EQ(result.exit_code, kExitUnreadable);
    EXPECT_THAT(result.err, StartsWith("error: "));
  }
}

TEST(StreamTest, ColorsOnlyOnATerminalAndWithoutNoColor) {
  if (!HasTerminals()) GTEST_SKIP() << "no pseudo-terminals here";
  const std::vector<std::string> arguments = {"frobnicate"};
  EXPECT_THAT(RunProgram(arguments).err, Not(HasSubstr("\033")));
  ProgramOptions options;
  options.stderr_is_terminal = true;
  options.environment = {"TERM=xterm", "NO_COLOR="};
  EXPECT_THAT(RunProgram(arguments, options).err, HasSubstr("\033[1;31merror:\033[0m"));
  options.environment = {"TERM=xterm", "NO_COLOR=1"};
  EXPECT_THAT(RunProgram(arguments, options).err, Not(HasSubstr("\033")));
  options.environment = {"TERM=dumb", "NO_COLOR="};
  EXPECT_THAT(RunProgram(arguments, options).err, Not(HasSubstr("\033")));
}

}  // namespace
}  // namespace hpgo
