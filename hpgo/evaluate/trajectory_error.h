// Absolute and relative errors of a trajectory against a reference (ATE and RPE as in J. Sturm et
// al., "A benchmark for the evaluation of RGB-D SLAM systems", IROS 2012).
#pragma once

#include <vector>

#include "hpgo/evaluate/alignment.h"
#include "hpgo/evaluate/statistics.h"

namespace hpgo {

template <typename G>
struct TrajectoryError {
  ErrorStatistics translation;  // m
  ErrorStatistics rotation;     // rad, the angle of the rotation between the two poses
  G T_reference_estimate;       // the alignment the errors were taken under; identity for RPE
};

// estimate[k] belongs to reference[k]. The errors of T_reference_estimate * estimate[k] against
// reference[k]. Errors: those of Align.
template <typename G>
Result<TrajectoryError<G>> AbsoluteTrajectoryError(const std::vector<G>& estimate,
                                                   const std::vector<G>& reference,
                                                   AlignmentMode mode = AlignmentMode::kRigid);

// Of the motions over `delta` poses, for every start: the deviation of estimate[k]^-1
// estimate[k + delta] from the reference's. Needs no alignment. kInvalidArgument: those of Align,
// or delta < 1, or no more than `delta` poses.
template <typename G>
Result<TrajectoryError<G>> RelativeTrajectoryError(const std::vector<G>& estimate,
                                                   const std::vector<G>& reference, int delta = 1);

}  // namespace hpgo
