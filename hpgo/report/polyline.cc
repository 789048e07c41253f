#include "hpgo/report/polyline.h"

#include <algorithm>
#include <utility>

namespace hpgo {
namespace {

double SquaredDistance(const Eigen::Vector2d& point, const Eigen::Vector2d& from,
                       const Eigen::Vector2d& to) {
  const Eigen::Vector2d along = to - from;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((point - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (point - from - t * along).squaredNorm();
}

}  // namespace

std::vector<int> SimplifyPolyline(const std::vector<Eigen::Vector2d>& points, double tolerance) {
  const int count = static_cast<int>(points.size());
  std::vector<char> keep(points.size(), 0);
  // An explicit stack: a spiral would recurse once a point.
  std::vector<std::pair<int, int>> open;
  if (count > 0) {
    keep.front() = keep.back() = 1;
    open.emplace_back(0, count - 1);
  }
  while (!open.empty()) {
    const auto [first, last] = open.back();
    open.pop_back();
    double worst = tolerance * tolerance;
    int split = -1;
    for (int k = first + 1; k < last; ++k) {
      const double distance = SquaredDistance(points[k], points[first], points[last]);
      if (distance > worst) {
        worst = distance;
        split = k;
      }
    }
    if (split < 0) continue;
    keep[split] = 1;
    open.emplace_back(first, split);
    open.emplace_back(split, last);
  }
  std::vector<int> kept;
  for (int k = 0; k < count; ++k) {
    if (keep[k] != 0) kept.push_back(k);
  }
  return kept;
}

}  // namespace hpgo
