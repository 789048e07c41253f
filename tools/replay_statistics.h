// What the updates of a replay took.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace hpgo_cli {

// Milliseconds of wall time by step of an update.
struct UpdateBreakdown {
  double insert = 0;   // adding the nodes and edges, and finding their groups
  double merge = 0;    // computing coarse edges anew
  double examine = 0;  // looking for stress
  double top = 0;      // solving the top level
  double windows = 0;
  double other = 0;  // what is left of the latency
};

// One update with the adding of what it inserts. Single precision: a replay may have millions.
struct UpdateSample {
  std::int32_t update = 0;  // counted from one
  bool closes_loop = false;
  float wall_ms = 0;
  float cpu_ms = 0;  // of this thread
  float insert_ms = 0, merge_ms = 0, examine_ms = 0, top_ms = 0, windows_ms = 0;
};

// Percentiles are the smallest samples that so many percent do not exceed. No sample: all zero.
struct LatencyFigures {
  double mean = 0, p50 = 0, p95 = 0, p99 = 0, max = 0;  // ms
};

// The percentiles are of the same kind.
struct Distribution {
  double mean = 0, median = 0, p90 = 0, max = 0;
};

struct UpdateGroup {
  std::string name;  // "all", "closures", "odometry"
  std::int64_t count = 0;
  LatencyFigures wall, cpu;
};

struct ReplayStatistics {
  std::vector<UpdateGroup> groups;  // all updates, those with a loop closure, those without
  UpdateBreakdown mean;
  std::int32_t worst_update = 0;  // the one with the largest wall time
  UpdateBreakdown worst;
};

// The names of the figures, in the order of reports.
const std::vector<std::pair<const char*, double UpdateBreakdown::*>>& BreakdownParts();
const std::vector<std::pair<const char*, double LatencyFigures::*>>& LatencyQuantiles();

const std::vector<std::pair<const char*, double Distribution::*>>& DistributionFigures();

Distribution Summarize(std::vector<double> values);

LatencyFigures SummarizeLatency(std::vector<float> milliseconds);

ReplayStatistics SummarizeUpdates(const std::vector<UpdateSample>& samples);

}  // namespace hpgo_cli
