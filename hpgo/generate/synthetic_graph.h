// Pose graphs as a SLAM front end would hand them over, with the truth behind them.
#pragma once

#include <vector>

#include "hpgo/generate/options.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// Node ids are 0, 1, 2, ... in time order, node 0 at the identity. The edges stand in the order a
// robot meets them: odometry from k - 1 to k, then the loop closures from k to older nodes. The
// initial estimate is dead reckoning along the measured odometry.
//
// The information of an edge is that of its noise in the error convention of g2o files: in 3D the
// rotational error is half the angle, so its weight is 4 / sigma^2. chi2 at the truth is then about
// the number of edges times the degrees of freedom, outliers aside.
template <typename G>
struct SyntheticGraph {
  PoseGraph<G> graph;
  std::vector<G> truth;            // by node index
  int closures = 0;                // of all edges; outliers included
  std::vector<int> outlier_edges;  // indices of the wrong closures, ascending
};

// kInvalidArgument: see CheckOptions; kTrajectory has no path of its own.
template <typename G>
Result<SyntheticGraph<G>> GenerateGraph(const GenerateOptions& options);

// Lays odometry and loop closures along `poses`, given in any frame and at any spacing;
// options.world and options.nodes do not matter. kInvalidArgument: see CheckOptions, or there is no
// pose, or one is not finite.
template <typename G>
Result<SyntheticGraph<G>> GenerateAlong(const std::vector<G>& poses,
                                        const GenerateOptions& options);

// The truth as a graph without edges, for writing and comparing.
template <typename G>
PoseGraph<G> TruthGraph(const SyntheticGraph<G>& synthetic);

}  // namespace hpgo
