// What the edges between groups are made of.
#pragma once

namespace hpgo {

enum class CoarseEdges {
  kGalerkin,   // the exact restriction of the fine edges at the current estimate
  kCondensed,  // the paper's: mean and marginal covariance of a local subgraph
};

}  // namespace hpgo
