// Which group a node joins: one step of the paper's Algorithm 1 over plain weights.
#pragma once

#include <vector>

namespace hpgo {

// A neighbouring group that the node could join.
struct GroupCandidate {
  int group = -1;
  int size = 0;
  double weight_to_group = 0;  // Sigma_in: of the node's edges into the group
  double group_weight = 0;     // Sigma_group: the sum of k over its members
};

// The modularity gain of joining (paper, eq. 5): Sigma_in / 2m - Sigma_group k / 2m^2.
double ModularityGain(const GroupCandidate& candidate, double node_weight, double total_weight);

// The position in `candidates` of the largest positive gain among the groups with fewer than
// `max_size` members, the first on ties; -1 for a group of its own.
int BestGroup(const std::vector<GroupCandidate>& candidates, double node_weight,
              double total_weight, int max_size);

}  // namespace hpgo
