// hpgo replay as a shell sees it: figures, files, comparisons, exit codes, Ctrl-C.
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <limits>
#include <numeric>
#include <sstream>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitComparison;
using hpgo_cli::kExitInterrupted;
using hpgo_cli::kExitMalformed;
using hpgo_cli::kExitOk;
using hpgo_cli::kExitUsage;
using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

// Odometry says 2 m, the closure 2.3 m: the three edges share the difference, chi2 = 3 * 0.1^2.
constexpr char kChain[] =
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 0 2 2.3 0 0 1 0 0 1 0 1\n";

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

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

class ReplayCommandTest : public ::testing::Test {
 protected:
  std::string Generate(std::vector<std::string> arguments, const std::string& name = "graph.g2o") {
    const std::string path = directory_.File(name);
    arguments.insert(arguments.begin(), {"generate", "--quiet", "--output=" + path});
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, kExitOk) << result.err;
    return path;
  }

  // What --stats_json says.
  json Replay(const std::string& graph, std::vector<std::string> arguments = {},
              int exit_code = kExitOk) {
    arguments.insert(arguments.begin(), {"replay", graph, "--stats_json=-"});
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    const json figures = json::parse(result.out, nullptr, false);
    EXPECT_FALSE(figures.is_discarded()) << result.out << result.err;
    return figures;
  }

  double Gap(const json& figures, std::size_t k) {
    return figures.at("comparisons").at(k).at("gap_percent").get<double>();
  }

  const TemporaryDirectory directory_;
};

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

TEST_F(ReplayCommandTest, AFarOffClosureIsTakenIn) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=400"});
  const json figures = Replay(graph, {"--far_closure=1e4"});
  const json& far = figures.at("far_closure");
  EXPECT_EQ(far.at("edge"), "20 -> 399");
  const double share = figures.at("cost").get<double>() / figures.at("edges").get<double>();
  EXPECT_NEAR(far.at("edge_chi2").get<double>() / share, 1e4, 200);
  int updates = 0;
  double gap = std::numeric_limits<double>::infinity();
  for (const json& point : far.at("points")) {
    EXPECT_GT(point.at("updates"), updates);
    updates = point.at("updates");
    gap = point.at("gap_percent");
  }
  EXPECT_LT(gap, 1);
  EXPECT_GE(far.at("points").at(0).at("gap_percent").get<double>(), gap * (1 - 1e-3));

  const ProgramResult text = RunProgram({"replay", graph, "--far_closure=1e4"});
  EXPECT_THAT(text.out, HasSubstr("\nclosure 20 -> 399, "));
  EXPECT_THAT(text.out, HasSubstr("\n  gap, % "));
  EXPECT_EQ(RunProgram({"replay", graph, "--far_closure=-1"}).exit_code, kExitUsage);
  const json robust = Replay(graph, {"--far_closure=1e4", "--loss=huber"});
  EXPECT_LT(robust.at("far_closure").at("points").back().at("gap_percent"), 1);
  const std::string chain = directory_.Write("chain.g2o", kChain);
  const ProgramResult small = RunProgram({"replay", chain, "--far_closure=10"});
  EXPECT_NE(small.exit_code, kExitOk);
  EXPECT_THAT(small.err, HasSubstr("a far-off closure needs 20 nodes"));
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

TEST_F(ReplayCommandTest, StaysNearTheFullOptimum) {
  for (const char* dim : {"--dim=2", "--dim=3"}) {
    const std::string graph = Generate({"--world=manhattan", "--nodes=600", dim});
    const json figures = Replay(graph, {"--compare_full=100,25,50,75,25", "--refine"});
    ASSERT_EQ(figures.at("comparisons").size(), 4u);
    for (std::size_t k = 0; k < 4; ++k) {
      const json& comparison = figures.at("comparisons")[k];
      EXPECT_EQ(comparison.at("percent"), 25 * (k + 1));
      EXPECT_EQ(comparison.at("nodes"), 150 * (k + 1));
      EXPECT_GE(Gap(figures, k), -1e-6);
      EXPECT_LT(Gap(figures, k), 0.2);
      EXPECT_LT(comparison.at("ate_m").get<double>(), 0.1);
    }
    const json& refine = figures.at("refine");
    EXPECT_TRUE(refine.at("at_rest").get<bool>());
    EXPECT_LE(refine.at("cost_after").get<double>(), refine.at("cost_before").get<double>());
    EXPECT_LT(refine.at("gap_percent_after").get<double>(), 0.2);
    EXPECT_NEAR(figures.at("chi2").get<double>(), refine.at("cost_after").get<double>(), 1e-6);
  }
}

TEST_F(ReplayCommandTest, FullModeReachesTheOptimum) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=200", "--dim=2"});
  for (const char* engine : {"--engine=ceres", "--engine=block"}) {
    const json figures = Replay(graph, {"--mode=full", "--compare_full=50,100", engine});
    EXPECT_NEAR(Gap(figures, 0), 0, 1e-4);
    EXPECT_NEAR(Gap(figures, 1), 0, 1e-4);
  }
  // Only the last updates are in that mode.
  const json measured =
      Replay(graph, {"--measure_mode=full", "--measure_updates=4", "--compare_full=100"});
  EXPECT_EQ(measured.at("settings").at("mode"), "full");
  EXPECT_EQ(measured.at("latency_ms").at("all").at("updates"), 4);
  EXPECT_EQ(measured.at("updates"), 200);
  EXPECT_NEAR(Gap(measured, 0), 0, 1e-4);
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

TEST_F(ReplayCommandTest, ComparesRightAfterClosingUpdates) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=250"});
  const json figures =
      Replay(graph, {"--mode=top", "--max_top_nodes=50", "--compare_at=closures:5"});
  const json& closing = figures.at("closing");
  EXPECT_EQ(closing.at("updates"), figures.at("latency_ms").at("closures").at("updates"));
  EXPECT_EQ(closing.at("compared"), 5);
  const json& comparisons = closing.at("comparisons");
  ASSERT_EQ(comparisons.size(), 5u);
  std::string percentages;
  std::vector<double> gaps, distances;
  for (const json& comparison : comparisons) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.12g", comparison.at("percent").get<double>() - 1e-9);
    percentages += (percentages.empty() ? "" : ",") + std::string(text);
    gaps.push_back(comparison.at("gap_percent"));
    distances.push_back(comparison.at("ate_m"));
  }
  // The same as asked for by the number of nodes, with an optimum found in another way.
  const json full =
      Replay(graph, {"--mode=top", "--max_top_nodes=50", "--compare_full=" + percentages});
  ASSERT_EQ(full.at("comparisons").size(), 5u);
  for (std::size_t k = 0; k < 5; ++k) {
    const json &expected = full.at("comparisons")[k], &comparison = comparisons[k];
    EXPECT_EQ(comparison.at("nodes"), expected.at("nodes"));
    EXPECT_EQ(comparison.at("cost"), expected.at("cost"));
    EXPECT_NEAR(comparison.at("optimum").get<double>(), expected.at("optimum").get<double>(),
                1e-6 * expected.at("optimum").get<double>() + 1e-9);
    EXPECT_NEAR(comparison.at("ate_m").get<double>(), expected.at("ate_m").get<double>(), 1e-4);
  }
  for (const auto& [name, values] :
       {std::make_pair("gap_percent", &gaps), std::make_pair("ate_m", &distances)}) {
    std::sort(values->begin(), values->end());
    const json& distribution = closing.at(name);
    EXPECT_NEAR(distribution.at("mean").get<double>(),
                std::accumulate(values->begin(), values->end(), 0.0) / 5, 1e-12 * values->back())
        << name;
    EXPECT_EQ(distribution.at("median"), (*values)[2]) << name;
    EXPECT_EQ(distribution.at("p90"), (*values)[4]) << name;
    EXPECT_EQ(distribution.at("max"), (*values)[4]) << name;
    EXPECT_GT((*values)[4], 0) << name;
  }
  // In full mode the estimate is the optimum.
  const json exact = Replay(graph, {"--mode=full", "--compare_at=closures"});
  EXPECT_EQ(exact.at("closing").at("compared"), 40);
  EXPECT_LT(exact.at("closing").at("gap_percent").at("max").get<double>(), 1e-4);
  EXPECT_LT(exact.at("closing").at("ate_m").at("max").get<double>(), 1e-4);
  // Of one, the last.
  const json last = Replay(graph, {"--compare_at=closures:1"});
  EXPECT_EQ(last.at("closing").at("comparisons")[0].at("nodes"), comparisons[4].at("nodes"));
}

TEST_F(ReplayCommandTest, ShowsTheGapsAfterClosures) {
  const std::string chain = directory_.Write("chain.g2o", kChain);
  const std::string chart = directory_.File("gaps.svg"), table = directory_.File("table.csv");
  const ProgramResult result = RunProgram(
      {"replay", chain, "--compare_at=closures:3", "--chart=" + chart, "--summary_csv=" + table});
  ASSERT_EQ(result.exit_code, kExitOk) << result.err;
  EXPECT_THAT(result.out, HasSubstr("\nright after 1 of 1 update with a loop closure:\n"));
  EXPECT_THAT(result.out, HasSubstr("\nto the optimum       mean   median      p90      max\n"));
  EXPECT_THAT(result.out, HasSubstr("\n  gap, % "));
  EXPECT_THAT(result.out, HasSubstr("\n  ATE, m "));
  EXPECT_THAT(result.err, HasSubstr("wrote " + chart + "\n"));
  EXPECT_THAT(ReadFile(chart), HasSubstr("ATE to the optimum, m</text>"));
  EXPECT_THAT(Lines(ReadFile(table))[0],
              HasSubstr(",closing_gap_percent_mean,closing_gap_percent_median,"
                        "closing_gap_percent_p90,closing_gap_percent_max,closing_ate_m_mean,"));

  const std::string open = directory_.Write("open.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
  const ProgramResult none = RunProgram(
      {"replay", open, "--compare_at=closures", "--chart=" + directory_.File("none.svg")});
  EXPECT_EQ(none.exit_code, kExitOk);
  EXPECT_THAT(none.err, HasSubstr("no chart: there was no loop closure to compare after"));
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

TEST_F(ReplayCommandTest, AThresholdDecidesTheExitCode) {
  const std::string graph = Generate({"--world=manhattan", "--nodes=300", "--dim=2"});
  Replay(graph, {"--compare_full=100", "--compare_threshold=1"});
  // The top level alone cannot follow.
  const json figures = Replay(
      graph,
      {"--mode=top", "--max_top_nodes=20", "--compare_full=100", "--compare_threshold=0.001"},
      kExitComparison);
  EXPECT_EQ(figures.at("exit_code"), kExitComparison);
  EXPECT_GT(Gap(figures, 0), 0.001);
  const ProgramResult result = RunProgram({"replay", graph, "--mode=top", "--max_top_nodes=20",
                                           "--compare_full=100", "--compare_threshold=0.001"});
  Replay(
      graph,
      {"--mode=top", "--max_top_nodes=20", "--compare_at=closures:2", "--compare_threshold=0.001"},
      kExitComparison);
  EXPECT_THAT(result.err, HasSubstr("error: the gap at 100 %, "));
  EXPECT_THAT(result.err, HasSubstr(" %, is above 0.001 %\n"));
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

TEST_F(ReplayCommandTest, MeasuresAgainstTheTruth) {
  const std::string truth = directory_.File("truth.g2o");
  const std::string graph =
      Generate({"--world=manhattan", "--nodes=300", "--ground_truth=" + truth});
  const json figures = Replay(graph, {"--reference=" + truth});
  EXPECT_EQ(figures.at("reference").at("poses"), 300);
  EXPECT_LT(figures.at("reference").at("ate_m").get<double>(), 1);
  const json planar = Replay(graph, {"--reference=" + truth, "--plane=xy"});
  EXPECT_LT(planar.at("reference").at("ate_m").get<double>(),
            figures.at("reference").at("ate_m").get<double>());
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

TEST_F(ReplayCommandTest, TheProgressLineIsForTerminals) {
  ProgramOptions options;
  options.input = kChain;
  EXPECT_THAT(RunProgram({"replay", "-"}, options).err, Not(HasSubstr("\r")));
  options.stderr_is_terminal = true;
  options.environment = {"TERM=xterm"};
  EXPECT_THAT(RunProgram({"replay", "-"}, options).err, HasSubstr("1 of 3 nodes, "));
  EXPECT_THAT(RunProgram({"replay", "-", "--quiet"}, options).err, IsEmpty());
}

TEST_F(ReplayCommandTest, CtrlCWritesWhatThereIs) {
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

TEST_F(ReplayCommandTest, TakesALoneNode) {
  const json figures = Replay(directory_.Write("lone.g2o", "VERTEX_SE2 5 1 2 0\n"));
  EXPECT_EQ(figures.at("updates"), 1);
  EXPECT_EQ(figures.at("chi2"), 0);
}

TEST_F(ReplayCommandTest, WrongValuesAreUsageErrors) {
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

// --- Saved states.

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

TEST_F(ReplayCommandTest, ResumesWithTheSameBits) {
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

TEST_F(ReplayCommandTest, RefusesStatesThatDoNotFit) {
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
