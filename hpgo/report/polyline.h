// Fewer points for the same picture.
#pragma once

#include <vector>

#include "Eigen/Core"

namespace hpgo {

// The indices of the points to keep so that no dropped point is farther than `tolerance` from the
// line drawn (Douglas and Peucker 1973). Keeps the first and the last. O(n log n) on usual input.
std::vector<int> SimplifyPolyline(const std::vector<Eigen::Vector2d>& points, double tolerance);

}  // namespace hpgo
