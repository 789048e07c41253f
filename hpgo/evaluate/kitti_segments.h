// The segment metric of the KITTI odometry benchmark (A. Geiger et al., "Are we ready for
// autonomous driving?", CVPR 2012), as its development kit computes it.
#pragma once

#include <vector>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "hpgo/graph/status.h"

namespace hpgo {

// The defaults are the benchmark's; shorter lengths serve shorter trajectories.
struct KittiSegmentOptions {
  std::vector<double> lengths = {100, 200, 300, 400, 500, 600, 700, 800};  // m, > 0
  int step = 10;  // every `step`-th pose starts a segment of each length
};

struct KittiSegmentErrors {
  double translation_ratio = 0;   // m of error per m of segment, the mean over all segments
  double rotation_rad_per_m = 0;  // likewise
  int segments = 0;               // 0: the reference is shorter than the shortest length
};

// estimate[k] belongs to reference[k]. A segment of length L from pose k ends at the first pose
// whose distance along the reference from k exceeds L; its error is that of the estimated motion
// between its ends, over L. Segments that the trajectory ends before are left out. The kit sums
// distances in single precision, this in double: a segment may end one pose apart.
// kInvalidArgument: the lengths of the trajectories differ, a pose is not finite, or an option is
// out of range.
template <typename G>
Result<KittiSegmentErrors> EvaluateKittiSegments(
    const std::vector<G>& estimate, const std::vector<G>& reference,
    const KittiSegmentOptions& options = KittiSegmentOptions());

}  // namespace hpgo
