// What linearizing anew overwrites, so that a step can be taken back.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "hpgo/chains/span.h"

namespace hpgo {

// A place in a log.
struct LogMark {
  std::size_t models = 0, edges = 0;
};

// Where spans and edges of a SpanTree were, in the order in which they were overwritten.
template <typename G>
struct LinearizationLog {
  std::vector<std::pair<Index, SpanModel<G>>> models;  // by span
  std::vector<std::pair<Index, G>> edges;              // T_previous_next by edge

  LogMark End() const { return {models.size(), edges.size()}; }
};

}  // namespace hpgo
