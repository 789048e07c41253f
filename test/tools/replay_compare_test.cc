// hpgo replay: how far the estimate is from the optimum and from the truth.

#include <algorithm>
#include <cstdio>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/replay_fixture.h"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {
namespace {

using hpgo_cli::kExitComparison;
using hpgo_cli::kExitOk;
using hpgo_cli::kExitUsage;
using nlohmann::json;
using ::testing::HasSubstr;

class ReplayCompareTest : public ReplayFixture {};

TEST_F(ReplayCompareTest, AFarOffClosureIsTakenIn) {
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

TEST_F(ReplayCompareTest, StaysNearTheFullOptimum) {
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

TEST_F(ReplayCompareTest, FullModeReachesTheOptimum) {
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

TEST_F(ReplayCompareTest, ComparesRightAfterClosingUpdates) {
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

TEST_F(ReplayCompareTest, ShowsTheGapsAfterClosures) {
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

TEST_F(ReplayCompareTest, AThresholdDecidesTheExitCode) {
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

TEST_F(ReplayCompareTest, MeasuresAgainstTheTruth) {
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

}  // namespace
}  // namespace hpgo
