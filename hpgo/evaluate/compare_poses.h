// Whether two graphs hold the same poses up to gauge.
#pragma once

#include "hpgo/evaluate/trajectory_error.h"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

// The differences of `graph`'s poses from those of `reference`, node by node of the same id, after
// one rigid alignment of all of them; max_index is an index into reference.nodes(). Edges do not
// matter. kNotFound names a node that only one of the two has; other errors are those of Align.
template <typename G>
Result<TrajectoryError<G>> ComparePosesUpToGauge(const PoseGraph<G>& graph,
                                                 const PoseGraph<G>& reference);

// The same without alignment: both are in one frame.
template <typename G>
Result<TrajectoryError<G>> ComparePoses(const PoseGraph<G>& graph, const PoseGraph<G>& reference);

}  // namespace hpgo
