// `hpgo evaluate`: figures, matching of poses, thresholds and refusals.
#include <cmath>
#include <filesystem>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitComparison;
using hpgo_cli::kExitMalformed;
using hpgo_cli::kExitOk;
using hpgo_cli::kExitUsage;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// Node 2 lies 1 m off what its edge says.
constexpr char kGraph[] =
    "VERTEX_SE2 0 0 0 0\n"
    "VERTEX_SE2 1 1 0 0\n"
    "VERTEX_SE2 2 1 3 1.5707963267948966\n"
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 1 2 0 2 1.5707963267948966 3 0 0 3 0 3\n";

// The figures, checked to be all that is on stdout.
json Figures(std::vector<std::string> arguments, int exit_code = kExitOk) {
  arguments.insert(arguments.begin(), "evaluate");
  arguments.push_back("--json=-");
  const ProgramResult result = RunProgram(arguments);
  EXPECT_EQ(result.exit_code, exit_code) << result.err;
  const json figures = json::parse(result.out, nullptr, false);
  EXPECT_FALSE(figures.is_discarded()) << result.out << result.err;
  return figures;
}

class EvaluateCommandTest : public ::testing::Test {
 protected:
  std::string Error(std::vector<std::string> arguments, int exit_code) {
    arguments.insert(arguments.begin(), "evaluate");
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    EXPECT_EQ(result.out, "");
    return result.err;
  }
  const TemporaryDirectory directory_;
  const std::string graph_ = directory_.Write("g.g2o", kGraph);
};

TEST_F(EvaluateCommandTest, PrintsChi2AndItsConvention) {
  const ProgramResult result = RunProgram({"evaluate", graph_});
  EXPECT_EQ(result.exit_code, kExitOk);
  EXPECT_EQ(result.out,
            "chi2  3.0000  (sum of e' Omega e, g2o error; 2 edges 3.0000, 0 priors 0.0000)\n");
  EXPECT_EQ(result.err, "");
  EXPECT_DOUBLE_EQ(Figures({graph_}).at("chi2"), 3);
  EXPECT_EQ(Figures({graph_, "--error=log"}).at("error"), "log");
}

TEST_F(EvaluateCommandTest, OtherPosesUnderTheGraphsEdges) {
  const std::string tum = directory_.Write("p.tum",
                                           "0 0 0 0 0 0 0 1\n"
                                           "1 1 0 0 0 0 0 1\n"
                                           "2 1 2 0 0 0 0.70710678118654757 0.70710678118654746\n");
  EXPECT_NEAR(Figures({tum, "--edges=" + graph_}).at("chi2").get<double>(), 0, 1e-15);
  const std::string short_tum = directory_.Write("s.tum", "0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(Error({short_tum, "--edges=" + graph_}, kExitUsage),
            "error: node 1 of " + graph_ + " has no pose in " + short_tum + "\n");
}

TEST_F(EvaluateCommandTest, ComparesWithAReferenceInEveryFormat) {
  const std::string g2o = directory_.Write("r.g2o",
                                           "VERTEX_SE2 2 1 2 1.5707963267948966\n"
                                           "VERTEX_SE2 0 0 0 0\n"
                                           "VERTEX_SE2 1 1 0 0\n");
  const std::string kitti = directory_.Write("r.txt",
                                             "1 0 0 0 0 1 0 0 0 0 1 0\n"
                                             "1 0 0 1 0 1 0 0 0 0 1 0\n"
                                             "0 -1 0 1 1 0 0 2 0 0 1 0\n");
  const std::string tum = directory_.Write("r.tum",
                                           "10.1 0 0 0 0 0 0 1\n"
                                           "10.2 1 0 0 0 0 0 1\n"
                                           "10.3 1 2 0 0 0 1 1\n");
  for (const auto& [file, by] : {std::make_pair(g2o, "id"), {kitti, "id"}, {tum, "order"}}) {
    const json figures = Figures({graph_, "--reference=" + file, "--alignment=none"});
    EXPECT_EQ(figures.at("matched_poses"), 3) << file;
    EXPECT_EQ(figures.at("matched_by"), by) << file;
    EXPECT_NEAR(figures["ate"]["translation_m"]["max"].get<double>(), 1, 1e-12) << file;
    EXPECT_NEAR(figures["ate"]["translation_m"]["rmse"].get<double>(), std::sqrt(1.0 / 3), 1e-12);
    EXPECT_NEAR(figures["ate"]["rotation_rad"]["max"].get<double>(), 0, 1e-12) << file;
    EXPECT_NEAR(figures["rpe"]["translation_m"]["mean"].get<double>(), 0.5, 1e-12) << file;
    EXPECT_FALSE(figures.contains("kitti")) << "3 m are no segment";
  }
}

TEST_F(EvaluateCommandTest, AThresholdMissedHasItsOwnExitCode) {
  EXPECT_EQ(Figures({graph_, "--max_chi2=3.1"}).at("exit_code"), kExitOk);
  EXPECT_EQ(Figures({graph_, "--max_chi2=2.9"}, kExitComparison).at("exit_code"), kExitComparison);
  const std::string reference = "--reference=" + directory_.Write("r.g2o", kGraph);
  EXPECT_EQ(Figures({graph_, reference, "--max_ate=1e-9"}).at("exit_code"), kExitOk);
  EXPECT_THAT(RunProgram({"evaluate", graph_, reference, "--max_chi2=1", "--max_ate=1"}).err,
              HasSubstr("error: chi2 3.0000 is above 1.0000\n"));
}

TEST_F(EvaluateCommandTest, RefusesWhatIsWrong) {
  EXPECT_EQ(Error({graph_, "--error=l2"}, kExitUsage),
            "error: --error=l2: must be g2o or log (see --help)\n");
  EXPECT_EQ(Error({graph_, "--plane=yz"}, kExitUsage),
            "error: --plane=yz: must be xy or xz (see --help)\n");
  EXPECT_EQ(Error({graph_, "--alignment=scale"}, kExitUsage),
            "error: --alignment=scale: must be rigid, first or none (see --help)\n");
  EXPECT_EQ(Error({"-", "--reference=-"}, kExitUsage),
            "error: only one file can be the standard input (see --help)\n");
  EXPECT_EQ(Error({graph_, "--max_ate=1"}, kExitUsage),
            "error: --max_ate needs --reference (see --help)\n");
  const std::string tum = directory_.Write("p.tum", "0 0 0 0 0 0 0 1\n");
  EXPECT_EQ(Error({tum}, kExitUsage),
            "error: " + tum + " has no edges: give --edges or --reference (see --help)\n");
  EXPECT_EQ(Error({tum, "--edges=" + tum}, kExitUsage),
            "error: --edges=" + tum + ": not a g2o or TORO file (see --help)\n");
  EXPECT_THAT(Error({directory_.Write("bad.g2o", "EDGE_SE2 0\n")}, kExitMalformed),
              StartsWith("error: " + directory_.File("bad.g2o") + ":1: "));
}

TEST_F(EvaluateCommandTest, FilesOfDifferentHoursAreMatchedByOrderOnlyIfAsked) {
  const auto hour = [](int begin, int count) {
    std::string text;
    for (int k = 0; k < count; ++k) {
      text += std::to_string(begin + k) + " " + std::to_string(k) + " 0 0 0 0 0 1\n";
    }
    return text;
  };
  const std::string early = directory_.Write("early.tum", hour(1000, 3));
  const std::string late = directory_.Write("late.tum", hour(5000, 3));
  const std::string shorter = directory_.Write("shorter.tum", hour(5000, 2));
  const std::string error =
      "error: no pose of " + early + " (by time, 1000 to 1002) belongs to one of ";
  EXPECT_EQ(Error({early, "--reference=" + late}, kExitUsage),
            error + late + " (by time, 5000 to 5002); --by_order matches them one by one\n");
  EXPECT_EQ(Error({early, "--reference=" + shorter}, kExitUsage),
            error + shorter + " (by time, 5000 to 5001)\n");
  EXPECT_EQ(Error({early, "--by_order", "--reference=" + shorter}, kExitUsage),
            error + shorter +
                " (by time, 5000 to 5001); --by_order needs as many poses in both, not 3 and 2\n");
  const json figures = Figures({early, "--by_order", "--reference=" + late});
  EXPECT_EQ(figures.at("matched_by"), "order");
  EXPECT_EQ(figures.at("matched_poses"), 3);
}

TEST_F(EvaluateCommandTest, KittiGraphAgainstItsCameraTruth) {
  const std::string folder = std::string(HPGO_SHARED_DATA_DIR) + "/kitti";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no KITTI data in " << folder;
  const std::string graph = folder + "/graphs/kitti_06.g2o";
  const std::string reference = "--reference=" + folder + "/gt/06.txt";
  const json figures = Figures({graph, reference, "--plane=xz"});
  EXPECT_NEAR(figures["kitti"]["translation_ratio"].get<double>() / 0.01170, 1, 0.02);
  EXPECT_NEAR(figures["kitti"]["rotation_rad_per_m"].get<double>() / 4.5e-5, 1, 0.02);
  EXPECT_NEAR(figures["ate"]["translation_m"]["rmse"].get<double>() / 3.2, 1, 0.02);
  EXPECT_THAT(RunProgram({"evaluate", graph, reference}).err,
              HasSubstr(" is 3D: seen in 2D it needs --plane=xy"));
}

}  // namespace
}  // namespace hpgo
