#include "hpgo/hierarchy/grouping.h"

namespace hpgo {

double ModularityGain(const GroupCandidate& candidate, double node_weight, double total_weight) {
  return candidate.weight_to_group / (2 * total_weight) -
         candidate.group_weight * node_weight / (2 * total_weight * total_weight);
}

int BestGroup(const std::vector<GroupCandidate>& candidates, double node_weight,
              double total_weight, int max_size) {
  int best = -1;
  double best_gain = 0;
  for (int c = 0; c < static_cast<int>(candidates.size()); ++c) {
    if (candidates[c].size >= max_size) continue;
    const double gain = ModularityGain(candidates[c], node_weight, total_weight);
    if (gain > best_gain) {
      best = c;
      best_gain = gain;
    }
  }
  return best;
}

}  // namespace hpgo
