// What the tests of hpgo replay share: graphs, and calls of it.
#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "nlohmann/json.hpp"
#include "test/tools/run_program.h"
#include "tools/command.h"

namespace hpgo {

// Odometry says 2 m, the closure 2.3 m: the three edges share the difference, chi2 = 3 * 0.1^2.
inline constexpr char kChain[] =
    "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1\n"
    "EDGE_SE2 0 2 2.3 0 0 1 0 0 1 0 1\n";

inline std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class ReplayFixture : public ::testing::Test {
 protected:
  std::string Generate(std::vector<std::string> arguments, const std::string& name = "graph.g2o") {
    const std::string path = directory_.File(name);
    arguments.insert(arguments.begin(), {"generate", "--quiet", "--output=" + path});
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, hpgo_cli::kExitOk) << result.err;
    return path;
  }

  // What --stats_json says.
  nlohmann::json Replay(const std::string& graph, std::vector<std::string> arguments = {},
                        int exit_code = hpgo_cli::kExitOk) {
    arguments.insert(arguments.begin(), {"replay", graph, "--stats_json=-"});
    const ProgramResult result = RunProgram(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.err;
    const nlohmann::json figures = nlohmann::json::parse(result.out, nullptr, false);
    EXPECT_FALSE(figures.is_discarded()) << result.out << result.err;
    return figures;
  }

  double Gap(const nlohmann::json& figures, std::size_t k) {
    return figures.at("comparisons").at(k).at("gap_percent").get<double>();
  }

  const TemporaryDirectory directory_;
};

}  // namespace hpgo
