#include "hpgo/update/report.h"

#include <algorithm>

namespace hpgo {

Motion Larger(const Motion& a, const Motion& b) {
  return {std::max(a.distance, b.distance), std::max(a.angle, b.angle)};
}

void Accumulate(const UpdateReport& step, UpdateReport* sum) {
  sum->status = step.status;
  sum->num_levels = step.num_levels;
  sum->mean_chi2 = step.mean_chi2;
  sum->new_nodes += step.new_nodes;
  sum->new_edges += step.new_edges;
  sum->merged_edges += step.merged_edges;
  sum->examined_edges += step.examined_edges;
  sum->windows += step.windows;
  sum->largest_moved = Larger(sum->largest_moved, step.largest_moved);
  sum->top_solves += step.top_solves;
  sum->solved_nodes += step.solved_nodes;
  sum->cost_decrease += step.cost_decrease;
  sum->insert_seconds += step.insert_seconds;
  sum->merge_seconds += step.merge_seconds;
  sum->examine_seconds += step.examine_seconds;
  sum->top_seconds += step.top_seconds;
  sum->window_seconds += step.window_seconds;
}

}  // namespace hpgo
