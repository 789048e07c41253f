// hpgo chart: what it draws and what it refuses.
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitMalformed;
using hpgo_cli::kExitOk;
using hpgo_cli::kExitUsage;
using ::testing::HasSubstr;
using ::testing::Not;

ProgramResult Chart(const std::string& table, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"chart", "-", "--output=-"});
  ProgramOptions options;
  options.input = table;
  return RunProgram(arguments, options);
}

constexpr char kTable[] =
    "nodes,engine,p50,p99\n"
    "1000,block,0.5,2\n"
    "1000,ceres,1.5,6\n"
    "10000,block,0.7,0\n"
    "10000,ceres,,7\n";

TEST(ChartCommandTest, DrawsACurveAColumnAndValue) {
  const ProgramResult result =
      Chart(kTable, {"--x=nodes", "--y=p50,p99=worst", "--by=engine", "--log", "--title=Latency"});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  for (const char* text : {">Latency<", ">nodes<", ">block p50<", ">ceres p50<", ">block worst<",
                           ">ceres worst<", ">10k<"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
}

TEST(ChartCommandTest, TakesTheFirstColumnAndAllOthersUnlessTold) {
  const ProgramResult result = Chart("k,square,cube\n1,1,1\n2,4,8\n", {});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  for (const char* text : {">k<", ">square<", ">cube<"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_THAT(Chart("k,square,cube\n1,1,1\n2,4,8\n", {"--y=cube"}).out, Not(HasSubstr("square")));
}

TEST(ChartCommandTest, NamesWhatIsWrong) {
  const auto expect = [](const std::string& table, const std::vector<std::string>& arguments,
                         int exit_code, const std::string& error) {
    const ProgramResult result = Chart(table, arguments);
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_EQ(result.err, "error: " + error + "\n");
    EXPECT_EQ(result.out, "");
  };
  expect(kTable, {"--y=p95"}, kExitUsage,
         "stdin has no column 'p95'; it has nodes, engine, p50, p99");
  expect(kTable, {"--y=engine"}, kExitMalformed, "stdin:2: 'block' in column engine is no number");
  expect("a,b\n1,2\n1,2,3\n", {}, kExitMalformed, "stdin:3: has 3 cells, the first line 2");
  expect("", {}, kExitMalformed, "stdin: is empty");
  EXPECT_EQ(RunProgram({"chart", "a.csv"}).err,
            "error: --output=FILE.svg is required (see --help)\n");
}

}  // namespace
}  // namespace hpgo
