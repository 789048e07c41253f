// hpgo hierarchy: figures that agree with one another, and a picture.
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitOk;
using hpgo_cli::kExitUsage;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string Generate(const TemporaryDirectory& directory, std::vector<std::string> arguments) {
  const std::string path = directory.File("graph.g2o");
  arguments.insert(arguments.begin(), {"generate", "--quiet", "--output=" + path});
  EXPECT_EQ(RunProgram(arguments).exit_code, kExitOk);
  return path;
}

json Figures(const std::string& graph, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {"hierarchy", graph, "--json=-"});
  const ProgramResult result = RunProgram(arguments);
  EXPECT_EQ(result.exit_code, kExitOk) << result.err;
  const json figures = json::parse(result.out, nullptr, false);
  EXPECT_FALSE(figures.is_discarded()) << result.out;
  return figures;
}

void ExpectConsistent(const json& figures, std::int64_t max_group_size,
                      std::int64_t max_top_nodes) {
  const json& levels = figures.at("levels");
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const json& level = levels[l];
    const auto nodes = level.at("nodes").get<std::int64_t>();
    const json& groups = level.at("groups_by_size");
    EXPECT_NEAR(level.at("fraction").get<double>(), nodes / levels[0].at("nodes").get<double>(),
                1e-12);
    if (l + 1 == levels.size()) {
      EXPECT_LE(nodes, max_top_nodes);
      EXPECT_TRUE(groups.empty());
      break;
    }
    EXPECT_LE(groups.size(), static_cast<std::size_t>(max_group_size));
    std::int64_t members = 0, count = 0;
    for (std::size_t k = 0; k < groups.size(); ++k) {
      count += groups[k].get<std::int64_t>();
      members += static_cast<std::int64_t>(k + 1) * groups[k].get<std::int64_t>();
    }
    const auto above = levels[l + 1].at("nodes").get<std::int64_t>();
    EXPECT_EQ(members, nodes);
    EXPECT_EQ(count, above);
    EXPECT_NEAR(levels[l + 1].at("reduction").get<double>(),
                static_cast<double>(nodes) / static_cast<double>(above), 1e-12);
    EXPECT_GT(level.at("modularity").get<double>(), -1);
    EXPECT_LT(level.at("modularity").get<double>(), 1);
  }
}

TEST(HierarchyCommandTest, CountsAreConsistent) {
  const TemporaryDirectory directory;
  for (const char* dim : {"--dim=2", "--dim=3"}) {
    const std::string graph = Generate(directory, {"--world=manhattan", "--nodes=2000", dim});
    const json figures = Figures(graph, {});
    ExpectConsistent(figures, 3, figures.at("max_top_nodes").get<std::int64_t>());
    EXPECT_EQ(figures.at("levels")[0].at("nodes"), 2000);
    EXPECT_GT(figures.at("levels").size(), 2u);
    EXPECT_GT(figures.at("levels")[1].at("reduction").get<double>(), 2.5);
    EXPECT_GT(figures.at("insertion_us").at("p50").get<double>(), 0);
    EXPECT_GT(figures.at("coarse_edges").at("count").get<int>(), 0);
  }
}

TEST(HierarchyCommandTest, TheFlagsDecideTheShape) {
  const TemporaryDirectory directory;
  const std::string graph = Generate(directory, {"--world=city", "--nodes=1000", "--dim=2"});
  const json small = Figures(graph, {"--max_group_size=2", "--max_top_nodes=40"});
  ExpectConsistent(small, 2, 40);
  EXPECT_EQ(small.at("max_group_size"), 2);
  const json flat = Figures(graph, {"--max_top_nodes=1000"});
  EXPECT_EQ(flat.at("levels").size(), 1u);
  const json condensed = Figures(graph, {"--max_top_nodes=40", "--coarse_edges=condensed"});
  ExpectConsistent(condensed, 3, 40);
  EXPECT_EQ(condensed.at("coarse_edges").at("kind"), "condensed");
  // How coarse edges are computed does not change who belongs to whom.
  EXPECT_EQ(condensed.at("levels"), Figures(graph, {"--max_top_nodes=40"}).at("levels"));
}

// Two cliques of two nodes with heavy edges, joined by a light one. With the edges' weights
// w = 1 / max(z' Omega z, 1e-6) = 1, 1 and 1/4: m = 2.25, each group holds 1 of it and has the
// weighted degree 2.25, so Q = 2 / 2.25 - 2 * (2.25 / 4.5)^2 = 7 / 18.
TEST(HierarchyCommandTest, ModularityIsThePapers) {
  const TemporaryDirectory directory;
  const std::string graph = directory.Write("four.g2o",
                                            "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
                                            "EDGE_SE2 1 2 2 0 0 1 0 0 1 0 1\n"
                                            "EDGE_SE2 2 3 1 0 0 1 0 0 1 0 1\n");
  const json figures = Figures(graph, {"--max_top_nodes=3", "--max_group_size=2"});
  ASSERT_EQ(figures.at("levels").size(), 2u);
  EXPECT_EQ(figures.at("levels")[0].at("groups_by_size"), json({0, 2}));
  EXPECT_NEAR(figures.at("levels")[0].at("modularity").get<double>(), 7.0 / 18, 1e-9);
}

TEST(HierarchyCommandTest, DrawsAPicture) {
  const TemporaryDirectory directory;
  const std::string graph = Generate(directory, {"--world=torus", "--nodes=800"});
  const std::string picture = directory.File("h.svg");
  const ProgramResult result =
      RunProgram({"hierarchy", graph, "--output=" + picture, "--title=Torus"});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_THAT(result.err, HasSubstr("wrote " + picture));
  EXPECT_THAT(result.out, StartsWith("level "));
  EXPECT_THAT(result.out, HasSubstr("insertion of a node: median "));
  const std::string svg = ReadFile(picture);
  EXPECT_THAT(svg, HasSubstr(">Torus<"));
  EXPECT_THAT(svg, HasSubstr(">level 1<"));
  const json figures = Figures(graph, {});
  EXPECT_THAT(svg, HasSubstr(">" + std::to_string(figures.at("levels")[1].at("nodes").get<int>()) +
                             " groups ("));
}

TEST(HierarchyCommandTest, TakesPriorsFixedNodesAndLoneNodes) {
  const TemporaryDirectory directory;
  const std::string graph = directory.Write("odd.g2o",
                                            "VERTEX_SE2 7 0 0 0\n"
                                            "VERTEX_SE2 8 1 0 0\n"
                                            "VERTEX_SE2 9 5 5 0\n"
                                            "VERTEX_SE2 10 2 0 0\n"
                                            "VERTEX_SE2 11 3 0 0\n"
                                            "FIX 7\n"
                                            "EDGE_SE2 7 8 1 0 0 1 0 0 1 0 1\n"
                                            "EDGE_SE2 8 10 1 0 0 1 0 0 1 0 1\n"
                                            "EDGE_SE2 10 11 1 0 0 1 0 0 1 0 1\n"
                                            "EDGE_PRIOR_SE2 8 1 0 0 1 0 0 1 0 1\n");
  const json figures = Figures(graph, {"--max_top_nodes=4"});
  EXPECT_EQ(figures.at("levels")[0].at("edges"), 4);  // a prior is one
  ASSERT_EQ(figures.at("levels").size(), 2u);
  ExpectConsistent(figures, 3, 4);
  EXPECT_GE(figures.at("levels")[0].at("groups_by_size")[0].get<int>(), 1);  // node 9
}

TEST(HierarchyCommandTest, RefusesWrongValues) {
  for (const char* flag : {"--max_group_size=1", "--max_top_nodes=1", "--coarse_edges=big"}) {
    const ProgramResult result = RunProgram({"hierarchy", "a.g2o", flag});
    EXPECT_EQ(result.exit_code, kExitUsage) << flag;
    EXPECT_THAT(result.err, StartsWith(std::string("error: ") + flag + ": must be "));
  }
}

}  // namespace
}  // namespace hpgo
