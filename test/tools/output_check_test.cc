// An output that cannot be written is found before the input is read: no command does the work for
// nothing.
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using Arguments = std::vector<std::string>;

class OutputCheckTest : public ::testing::TestWithParam<Arguments> {};

TEST_P(OutputCheckTest, ComesFirst) {
  const TemporaryDirectory directory;
  const std::string output = directory.File("no/such/file");
  Arguments arguments = GetParam();
  // Were the input read first, the message would be about that.
  for (std::string& argument : arguments) {
    const std::size_t at = argument.find("OUTPUT");
    if (at != std::string::npos) argument.replace(at, 6, output);
    if (argument == "INPUT") argument = directory.File("missing.g2o");
  }
  const ProgramResult result = RunProgram(arguments);
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitUnreadable);
  EXPECT_EQ(result.out, "");
  EXPECT_EQ(result.err, "error: " + output + ": cannot be created: No such file or directory\n");
  EXPECT_TRUE(directory.List().empty());
}

TEST(OutputsTest, AreDifferentFiles) {
  const TemporaryDirectory directory;
  const std::string file = directory.File("both");
  const ProgramResult result =
      RunProgram({"optimize", "missing.g2o", "--output=" + file, "--stats_json=" + file});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitUsage);
  EXPECT_EQ(result.err, "error: --output and --stats_json cannot be the same file\n");
}

TEST(InputsTest, WithoutANameAreQuoted) {
  const ProgramResult result = RunProgram({"check", ""});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitUnreadable);
  EXPECT_EQ(result.err, "error: '': cannot be opened: No such file or directory\n");
}

INSTANTIATE_TEST_SUITE_P(
    Commands, OutputCheckTest,
    ::testing::Values(Arguments{"optimize", "INPUT", "--output=OUTPUT"},
                      Arguments{"optimize", "INPUT", "--stats_json=OUTPUT"},
                      Arguments{"replay", "INPUT", "--output=OUTPUT"},
                      Arguments{"replay", "INPUT", "--stats_csv=OUTPUT"},
                      Arguments{"replay", "INPUT", "--stats_json=OUTPUT"},
                      Arguments{"replay", "INPUT", "--summary_csv=OUTPUT"},
                      Arguments{"replay", "INPUT", "--save=OUTPUT"},
                      Arguments{"replay", "INPUT", "--compare_at=100", "--chart=OUTPUT"},
                      Arguments{"evaluate", "INPUT", "--json=OUTPUT"},
                      Arguments{"generate", "--output=OUTPUT"},
                      Arguments{"generate", "--output=-", "--ground_truth=OUTPUT"},
                      Arguments{"plot", "INPUT", "--output=OUTPUT"},
                      Arguments{"chart", "INPUT", "--output=OUTPUT"},
                      Arguments{"hierarchy", "INPUT", "--output=OUTPUT"},
                      Arguments{"hierarchy", "INPUT", "--json=OUTPUT"},
                      Arguments{"convert", "--to=g2o", "INPUT", "OUTPUT"}));

}  // namespace
}  // namespace hpgo
