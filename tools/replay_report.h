// What a replay has shown: for people, as JSON, and as one line of a table.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "nlohmann/json.hpp"
#include "tools/replay_recovery.h"
#include "tools/replay_run.h"

namespace hpgo_cli {

struct LevelSize {
  std::int64_t nodes = 0, edges = 0;
};

template <typename G>
std::vector<LevelSize> LevelSizes(const hpgo::Hierarchy<G>& hierarchy);

// Names of the settings, as on the command line.
struct ReplayNames {
  std::string input, preset, mode, solve_every;
};

struct ReplayFigures {
  ReplayNames names;
  ReplaySettings settings;
  ReplayResult result;
  ReplayStatistics statistics;
  std::int64_t nodes = 0, edges = 0;  // of the graph, priors among the edges
  std::vector<LevelSize> levels;      // of the hierarchy over its kept nodes
  double chi2 = 0, cost = 0;          // at the end
  std::optional<ReferenceError> reference;
  std::optional<Recovery> recovery;
  hpgo::Status recovery_failure;
};

inline constexpr double kMegabyte = 1e6;

// A name flushed left, then cells flushed right in columns of one width.
std::string TableRow(const std::string& name, const std::vector<std::string>& cells);
// One number by a format of printf.
std::string FormatAs(const char* format, double value);

// The file's name without its folder.
std::string BaseName(const std::string& path);

// Bytes of the optimizer over the nodes of level 0.
double BytesPerNode(const ReplayFigures& figures);

void PrintReplay(const ReplayFigures& figures,
                 const std::function<void(const std::string&)>& print_line);

// --- replay_record.cc

nlohmann::ordered_json ReplayJson(const ReplayFigures& figures);

// Adds a line with these figures to a CSV file; writes its header first where there is no such
// file. kMalformed if the file has another header, which CheckSummaryCsv finds before a replay.
hpgo::Status CheckSummaryCsv(const std::string& path);
hpgo::Status AppendSummaryCsv(const ReplayFigures& figures, const std::string& path);

}  // namespace hpgo_cli
