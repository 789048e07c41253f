#include "hpgo/update/options.h"

#include <limits>

namespace hpgo {

OptimizerOptions OptimizerOptions::Fast() {
  OptimizerOptions options;
  options.window_nodes = 50;
  options.max_top_nodes = 100;
  options.max_windows = 2;
  options.stress_threshold = 1e-3;
  return options;
}

OptimizerOptions OptimizerOptions::Eager() {
  OptimizerOptions options;
  options.schedule = Schedule::kNewEdges;
  options.condense_chains = false;
  options.max_top_nodes = 300;
  options.max_top_edges = std::numeric_limits<int>::max();
  return options;
}

OptimizerOptions OptimizerOptions::Paper() {
  OptimizerOptions options = Eager();
  options.coarse_edges = CoarseEdges::kCondensed;
  options.schedule = Schedule::kNewestNode;
  options.window_nodes = 2000;
  options.window_edges = 10000;
  return options;
}

Result<OptimizerOptions> OptimizerOptions::FromName(const std::string& name) {
  if (name == "accurate") return Accurate();
  if (name == "fast") return Fast();
  if (name == "eager") return Eager();
  if (name == "paper") return Paper();
  return Status(StatusCode::kInvalidArgument,
                "no preset '" + name + "': accurate, fast, eager or paper");
}

Status OptimizerOptions::Validate() const {
  const auto at_least = [](const char* field, int value, int bound) {
    if (value >= bound) return Status::Ok();
    return Status(StatusCode::kInvalidArgument,
                  std::string(field) + " is " + std::to_string(value) + ", and must be at least " +
                      std::to_string(bound));
  };
  for (const Status& status :
       {at_least("max_group_size", max_group_size, 2), at_least("max_top_nodes", max_top_nodes, 2),
        at_least("max_top_edges", max_top_edges, 1), at_least("window_nodes", window_nodes, 1),
        at_least("window_edges", window_edges, 1), at_least("max_windows", max_windows, 1),
        at_least("window_iterations", window_iterations, 1),
        at_least("max_examined", max_examined, 1), at_least("max_merges", max_merges, 1)}) {
    if (!status.ok()) return status;
  }
  if (!(stress_threshold >= 0)) {
    return Status(StatusCode::kInvalidArgument, "stress_threshold is negative or not a number");
  }
  return Status::Ok();
}

}  // namespace hpgo
