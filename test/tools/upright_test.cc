// --dof=4 of hpgo replay and optimize: roll and pitch stay those of the file.
#include <string>
#include <variant>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/graph/upright.h"
#include "hpgo/io/g2o_reader.h"
#include "nlohmann/json.hpp"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using ::testing::HasSubstr;

class UprightCommandTest : public ::testing::Test {
 protected:
  std::string Generate(const std::string& dim) {
    const std::string path = directory_.File("graph" + dim + ".g2o");
    const ProgramResult result =
        RunProgram({"generate", "--world=manhattan", "--nodes=200", "--closure_density=0.3",
                    "--dim=" + dim, "--quiet", "--output=" + path});
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
    return path;
  }

  PoseGraph<SE3> Read(const std::string& path) {
    Result<AnyGraphFile> file = ReadG2o(path, ReadOptions(), nullptr);
    EXPECT_TRUE(file.ok()) << file.status().ToString();
    return std::get<GraphFile<SE3>>(*file).graph;
  }

  // Roll and pitch are where a pose sees z.
  void ExpectSameTilts(const std::string& before, const std::string& after) {
    const PoseGraph<SE3> a = Read(before), b = Read(after);
    ASSERT_EQ(a.nodes().size(), b.nodes().size());
    ASSERT_EQ(a.edges().size(), b.edges().size());
    double moved = 0;
    for (const GraphNode<SE3>& node : a.nodes()) {
      const SE3& pose = b.nodes()[*b.Find(node.id)].pose;
      EXPECT_LE((node.pose.matrix().row(2) - pose.matrix().row(2)).norm(), 1e-12) << node.id;
      moved += node.pose.LocalCoordinates(pose).norm();
    }
    EXPECT_GT(moved, 0.1);
  }

  // Of the optimum.
  static double Chi2(const std::string& graph, const std::string& dof) {
    const ProgramResult result = RunProgram({"optimize", graph, dof, "--stats_json=-"});
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
    return nlohmann::json::parse(result.out).at("chi2_after").get<double>();
  }

  const TemporaryDirectory directory_;
};

TEST_F(UprightCommandTest, Optimize) {
  const std::string graph = Generate("3"), output = directory_.File("out.g2o");
  double chi2[2] = {};
  for (const std::string engine : {"block", "ceres"}) {
    const ProgramResult result = RunProgram({"optimize", graph, "--dof=4", "--engine=" + engine,
                                             "--output=" + output, "--stats_json=-"});
    ASSERT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
    chi2[engine == "ceres"] = nlohmann::json::parse(result.out).at("chi2_after").get<double>();
    ExpectSameTilts(graph, output);
  }
  EXPECT_NEAR(chi2[0], chi2[1], 1e-5 * chi2[0]);
}

TEST_F(UprightCommandTest, Replay) {
  const std::string graph = Generate("3"), output = directory_.File("out.g2o");
  const ProgramResult result =
      RunProgram({"replay", graph, "--dof=4", "--refine", "--compare_full=100",
                  "--output=" + output, "--stats_json=-"});
  ASSERT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
  const nlohmann::json figures = nlohmann::json::parse(result.out);
  ExpectSameTilts(graph, output);
  const double optimum = Chi2(graph, "--dof=4");
  EXPECT_NEAR(figures.at("chi2").get<double>(), optimum, 1e-3 * optimum);
}

TEST_F(UprightCommandTest, GoesOnFromASavedState) {
  const std::string graph = Generate("3"), state = directory_.File("state");
  const std::string once = directory_.File("once.g2o"), resumed = directory_.File("resumed.g2o");
  ASSERT_EQ(
      RunProgram({"replay", graph, "--dof=4", "--output=" + once, "--save=" + state}).exit_code,
      hpgo_cli::kExitOk);
  const ProgramResult result =
      RunProgram({"replay", graph, "--dof=4", "--output=" + resumed, "--resume=" + state});
  EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
  EXPECT_EQ(ReadFile(once), ReadFile(resumed));
  const ProgramResult whole = RunProgram({"replay", graph, "--resume=" + state});
  EXPECT_EQ(whole.exit_code, hpgo_cli::kExitMalformed);
  EXPECT_THAT(whole.err, HasSubstr("is the state of a graph over x, y, z and yaw, not of a 3D"));
}

TEST_F(UprightCommandTest, SixAreAllOf3d) {
  const std::string graph = Generate("3");
  EXPECT_EQ(Chi2(graph, "--dof=6"), Chi2(graph, "--dof=0"));
  EXPECT_NE(Chi2(graph, "--dof=6"), Chi2(graph, "--dof=4"));
}

TEST_F(UprightCommandTest, Refusals) {
  const std::string plane = Generate("2");
  const std::string edges = directory_.Write(
      "edges.g2o", "EDGE_SE3:QUAT 0 1 1 0 0 0 0 0 1 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1\n");
  for (const std::string command : {"replay", "optimize"}) {
    const auto expect_refused = [&](const std::string& file, const std::string& dof,
                                    const std::string& message) {
      const ProgramResult result = RunProgram({command, file, dof});
      EXPECT_EQ(result.exit_code, hpgo_cli::kExitUsage);
      EXPECT_THAT(result.err, HasSubstr(message));
    };
    expect_refused(plane, "--dof=4", plane + ": --dof=4 is for 3D graphs");
    expect_refused(plane, "--dof=6", plane + ": --dof=6 is for 3D graphs");
    expect_refused(edges, "--dof=4", edges + ": --dof=4: node 0 has no pose");
    expect_refused(plane, "--dof=5", "--dof=5: must be 4 or 6");
    expect_refused(plane, "--dof=four", "dof");
  }
}

}  // namespace
}  // namespace hpgo
