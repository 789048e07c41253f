// How a redescending loss is approached.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "ceres/loss_function.h"

namespace hpgo {

// The losses to minimize one after the other, the last being the loss itself; just that one where
// it is not redescending. A redescending loss (tukey, geman_mcclure, dcs) lets go of every edge
// that is far off at the start, right or wrong. Huber's, which begins to bend at the same error, is
// convex and lets go of none; after it come the loss at four times and at twice its scale (of the
// error, as Yang et al., graduated non-convexity, RA-L 2020, do it).
// `name` and `scale` must be good for ceres_costs::MakeLoss; "none" gives one null.
std::vector<std::unique_ptr<ceres::LossFunction>> GraduatedLosses(const std::string& name,
                                                                  double scale);

}  // namespace hpgo
