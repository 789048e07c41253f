// hpgo replay as a shell sees it: figures and files.

#include <string>
#include <vector>

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
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::StartsWith;

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

class ReplayCommandTest : public ReplayFixture {};

TEST_F(ReplayCommandTest, PrintsASummaryAndWritesTheEstimate) {
  const std::string graph = directory_.Write("chain.g2o", kChain);
  const std::string output = directory_.File("out.g2o");
  const ProgramResult result = RunProgram({"replay", graph, "--refine", "--output=" + output});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_THAT(result.err, StartsWith("read " + graph + ": 2D, 3 nodes, 3 edges, 0 priors in "));
  EXPECT_THAT(result.err, HasSubstr("wrote " + output + "\n"));
  EXPECT_THAT(result.out, StartsWith("3 updates in "));
  for (const char* text :
       {"\nlatency, ms ", "\n  all ", "\n  closures ", "\n  odometry ", "\n  worst ",
        "\nlevels over the kept nodes, nodes/edges: ", "\nmemory: ", "\nat 100 %: gap ",
        "\nrefined: gap ", "\nchi2 0.030000\n"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const std::string written = ReadFile(output);
  EXPECT_THAT(written, StartsWith("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1."));
  EXPECT_THAT(written, HasSubstr(kChain));
}

TEST_F(ReplayCommandTest, TheCsvHasALineAnUpdate) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=300", "--dim=2"});
  const ProgramResult result =
      RunProgram({"replay", graph, "--stats_csv=-", "--chi2_every=100", "--quiet"});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_EQ(result.err, "");
  const std::vector<std::string> lines = Lines(result.out);
  ASSERT_EQ(lines.size(), 301u);
  EXPECT_EQ(lines[0], "update,nodes,edges,latency_us,windows,solved_nodes,levels,chi2");
  int edges = 0;
  for (int k = 1; k <= 300; ++k) {
    const std::vector<std::string> cells = Cells(lines[k]);
    ASSERT_EQ(cells.size(), 8u) << lines[k];
    EXPECT_EQ(cells[0], std::to_string(k));
    EXPECT_EQ(cells[1], std::to_string(k));
    EXPECT_GE(std::stoi(cells[2]), edges);
    edges = std::stoi(cells[2]);
    EXPECT_GT(std::stod(cells[3]), 0);
    EXPECT_EQ(cells[7].empty(), k % 100 != 0) << lines[k];
  }
  const json figures = Replay(graph);
  EXPECT_EQ(figures.at("edges"), edges);
  EXPECT_NEAR(std::stod(Cells(lines[300])[7]), figures.at("chi2").get<double>(), 1e-3);
}

TEST_F(ReplayCommandTest, TheJsonHoldsAllFigures) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=400"});
  const json figures = Replay(graph, {"--stats_from=0.75"});
  EXPECT_EQ(figures.at("updates"), 400);
  EXPECT_EQ(figures.at("failed_updates"), 0);
  EXPECT_EQ(figures.at("interrupted"), false);
  EXPECT_EQ(figures.at("exit_code"), 0);
  EXPECT_EQ(figures.at("settings").at("preset"), "accurate");
  const json& latency = figures.at("latency_ms");
  EXPECT_EQ(latency.at("all").at("updates"), 100);
  EXPECT_EQ(latency.at("closures").at("updates").get<int>() +
                latency.at("odometry").at("updates").get<int>(),
            100);
  for (const char* clock : {"wall", "cpu"}) {
    const json& all = latency.at("all").at(clock);
    EXPECT_GT(all.at("p50").get<double>(), 0);
    EXPECT_LE(all.at("p50"), all.at("p95"));
    EXPECT_LE(all.at("p95"), all.at("p99"));
    EXPECT_LE(all.at("p99"), all.at("max"));
  }
  double sum = 0;
  for (const char* part : {"insert", "merge", "examine", "top", "windows", "other"}) {
    sum += figures.at("breakdown_ms").at("mean").at(part).get<double>();
  }
  EXPECT_NEAR(sum, latency.at("all").at("wall").at("mean").get<double>(), 1e-4 + 1e-3 * sum);
  EXPECT_GT(figures.at("breakdown_ms").at("worst_update").get<int>(), 300);
  EXPECT_GT(figures.at("work").at("top_solves").get<int>(), 0);
  EXPECT_EQ(figures.at("nodes"), 400);
  // Chains are condensed: level 0 is the nodes between them.
  EXPECT_LT(figures.at("levels")[0].at("nodes").get<int>(), 400);
  EXPECT_GT(figures.at("bytes_per_node").get<double>(), 300);
  EXPECT_GT(figures.at("peak_memory_bytes").get<double>(), 1e6);
  EXPECT_TRUE(figures.at("comparisons").empty());
}

TEST_F(ReplayCommandTest, EveryPresetAndModeRuns) {
  const std::string graph = Generate({"--world=city", "--nodes=500", "--dim=2"});
  for (const char* preset : {"accurate", "fast", "eager", "paper"}) {
    for (const char* mode : {"partial", "top"}) {
      const json figures = Replay(graph, {"--preset", preset, "--mode", mode});
      EXPECT_EQ(figures.at("settings").at("preset"), preset);
      EXPECT_EQ(figures.at("settings").at("mode"), mode);
      EXPECT_EQ(figures.at("updates"), 500);
      EXPECT_EQ(figures.at("failed_updates"), 0);
    }
  }
  const json overridden =
      Replay(graph, {"--window_nodes=7", "--max_top_nodes=60", "--max_windows=2"});
  EXPECT_EQ(overridden.at("settings").at("window_nodes"), 7);
  EXPECT_EQ(overridden.at("settings").at("max_windows"), 2);
  EXPECT_LE(overridden.at("levels").back().at("nodes").get<int>(), 60);
}

TEST_F(ReplayCommandTest, GathersNodesBetweenUpdates) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=250", "--dim=2"});
  const json each = Replay(graph);
  const int closures = each.at("latency_ms").at("closures").at("updates");
  ASSERT_GT(closures, 10);

  const json tenth = Replay(graph, {"--solve_every=100", "--compare_full=50,100"});
  EXPECT_EQ(tenth.at("updates"), 3);  // at 100, 200 and the last node
  EXPECT_EQ(tenth.at("nodes"), 250);
  EXPECT_EQ(tenth.at("edges"), each.at("edges"));
  // At the first update with half of the nodes.
  EXPECT_EQ(tenth.at("comparisons")[0].at("nodes"), 200);

  const json loop = Replay(graph, {"--solve_every=loop"});
  const int updates = loop.at("updates");
  EXPECT_THAT(updates, ::testing::AnyOf(closures, closures + 1));  // the last node has one
  EXPECT_EQ(loop.at("latency_ms").at("closures").at("updates"), closures);
}

TEST_F(ReplayCommandTest, UpdatesAtClosuresOnly) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=250", "--dim=2"});
  const json loop = Replay(graph, {"--solve_every=loop"});
  const json closures = Replay(graph, {"--update_at=closures"});
  EXPECT_EQ(closures.at("updates"), loop.at("updates"));
  EXPECT_EQ(closures.at("chi2"), loop.at("chi2"));
  EXPECT_EQ(closures.at("settings"), loop.at("settings"));
  EXPECT_THAT(RunProgram({"replay", graph, "--update_at=closures", "--solve_every=5"}).err,
              StartsWith("error: --solve_every=5: does not go with --update_at=closures"));
}

// Nodes that start in poses taken long ago are far from their neighbours' estimates.
TEST_F(ReplayCommandTest, PosesNewNodesInAStaleEstimate) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=250", "--dim=2"});
  const json current = Replay(graph, {"--mode=top", "--max_top_nodes=50"});
  const json stale = Replay(graph, {"--mode=top", "--max_top_nodes=50", "--stale_poses=40"});
  EXPECT_EQ(stale.at("settings").at("stale_poses"), 40);
  // New nodes are put where their edges say: nothing is left of the client's old estimate.
  EXPECT_LT(stale.at("chi2").get<double>(), 1.01 * current.at("chi2").get<double>());
  // One that reads them after every update has the current ones.
  EXPECT_NEAR(Replay(graph, {"--stale_poses=1"}).at("chi2").get<double>(),
              Replay(graph).at("chi2").get<double>(), 1e-9);
  const json full = Replay(graph, {"--mode=full", "--stale_poses=40", "--compare_at=closures:10"});
  EXPECT_LT(full.at("closing").at("gap_percent").at("max").get<double>(), 1e-4);
}

TEST_F(ReplayCommandTest, EqualReplaysWriteEqualFiles) {
  for (const char* engine : {"--engine=ceres", "--engine=block"}) {
    const std::string graph = Generate({"--world=manhattan", "--nodes=300"});
    const ProgramResult first = RunProgram({"replay", graph, "--output=-", engine});
    ASSERT_EQ(first.exit_code, kExitOk) << first.err;
    EXPECT_THAT(first.out, HasSubstr("VERTEX_SE3:QUAT 299 "));
    EXPECT_EQ(first.out, RunProgram({"replay", graph, "--output=-", engine}).out);
  }
}

// Two chains that an edge joins late, a lone node, a fixed one, a prior, a doubled edge.
TEST_F(ReplayCommandTest, TakesComponentsPriorsAndFixedNodes) {
  const std::string graph = directory_.Write(
      "odd.g2o",
      "VERTEX_SE2 0 3 4 0\nVERTEX_SE2 1 0 0 0\nVERTEX_SE2 2 0 0 0\nVERTEX_SE2 10 0 0 0\n"
      "VERTEX_SE2 11 0 0 0\nVERTEX_SE2 12 0 0 0\nVERTEX_SE2 20 9 9 1\n"
      "FIX 0\n"
      "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 0 1 1.2 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 10 11 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 2 12 1 0 0 1 0 0 1 0 1\n"
      "EDGE_SE2 11 12 0 1 0 1 0 0 1 0 1\n"
      "EDGE_PRIOR_SE2 2 5 4 0 2 0 0 2 0 2\n");
  const std::string output = directory_.File("out.g2o");
  const json figures = Replay(graph, {"--output=" + output, "--refine"});
  EXPECT_EQ(figures.at("nodes"), 7);
  EXPECT_EQ(figures.at("edges"), 7);
  EXPECT_NEAR(Gap(figures, 0), 0, 0.01);
  EXPECT_LT(figures.at("refine").at("gap_percent_after").get<double>(), 0.01);
  const std::string written = ReadFile(output);
  EXPECT_THAT(written, StartsWith("VERTEX_SE2 0 3 4 0\n"));  // fixed
  EXPECT_THAT(written, HasSubstr("\nVERTEX_SE2 20 9 9 1\n"));
  EXPECT_THAT(written, HasSubstr("\nFIX 0\n"));
}

TEST_F(ReplayCommandTest, LossesAreForClosures) {
  const std::string graph =
      Generate({"--world=manhattan", "--nodes=300", "--dim=2", "--outliers=0.05"});
  const json squared = Replay(graph);
  const json robust = Replay(graph, {"--loss=cauchy", "--loss_scale=2", "--compare_full=100"});
  EXPECT_NEAR(squared.at("cost").get<double>(), squared.at("chi2").get<double>(), 1e-6);
  EXPECT_LT(robust.at("cost").get<double>(), 0.5 * robust.at("chi2").get<double>());
  EXPECT_EQ(robust.at("settings").at("loss"), "cauchy");
}

TEST_F(ReplayCommandTest, AddsLinesToATable) {
  const std::string graph = Generate({"--world=city", "--nodes=200", "--dim=2"});
  const std::string table = directory_.File("table.csv");
  for (const char* engine : {"--engine=ceres", "--engine=block"}) {
    ASSERT_EQ(RunProgram({"replay", graph, engine, "--summary_csv=" + table}).exit_code, kExitOk);
  }
  const std::vector<std::string> lines = Lines(ReadFile(table));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_THAT(lines[0], StartsWith("input,nodes,edges,preset,engine,mode,updates,all,"));
  EXPECT_THAT(lines[1], StartsWith("graph.g2o,200,"));
  EXPECT_THAT(lines[1], HasSubstr(",ceres,partial,200,200,"));
  EXPECT_THAT(lines[2], HasSubstr(",block,partial,200,200,"));
  EXPECT_EQ(Cells(lines[0]).size(), Cells(lines[2]).size());

  const std::string other = directory_.Write("other.csv", "a,b\n1,2\n");
  const ProgramResult result = RunProgram({"replay", graph, "--summary_csv=" + other});
  EXPECT_EQ(result.exit_code, kExitMalformed);
  EXPECT_THAT(result.err,
              HasSubstr("error: " + other + ":1: has other columns than a summary of hpgo replay"));
  EXPECT_EQ(ReadFile(other), "a,b\n1,2\n");
  // Found before the work, as the missing input tells.
  EXPECT_EQ(RunProgram({"replay", "nowhere.g2o", "--summary_csv=" + other}).exit_code,
            kExitMalformed);
}

TEST_F(ReplayCommandTest, TakesALoneNode) {
  const json figures = Replay(directory_.Write("lone.g2o", "VERTEX_SE2 5 1 2 0\n"));
  EXPECT_EQ(figures.at("updates"), 1);
  EXPECT_EQ(figures.at("chi2"), 0);
}

}  // namespace
}  // namespace hpgo
