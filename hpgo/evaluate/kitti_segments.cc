#include "hpgo/evaluate/kitti_segments.h"

#include <algorithm>

#include "hpgo/evaluate/alignment.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

template <typename G>
std::vector<double> DistancesAlong(const std::vector<G>& poses) {
  std::vector<double> distance(poses.size(), 0.0);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    distance[k] = distance[k - 1] + (poses[k].translation() - poses[k - 1].translation()).norm();
  }
  return distance;
}

}  // namespace

template <typename G>
Result<KittiSegmentErrors> EvaluateKittiSegments(const std::vector<G>& estimate,
                                                 const std::vector<G>& reference,
                                                 const KittiSegmentOptions& options) {
  const Result<G> checked = Align(estimate, reference, AlignmentMode::kIdentity);
  if (!checked.ok()) return checked.status();
  if (options.step < 1) return Status(StatusCode::kInvalidArgument, "segment step below 1");
  for (double length : options.lengths) {
    if (!(length > 0)) return Status(StatusCode::kInvalidArgument, "segment length not above 0");
  }

  const std::vector<double> distance = DistancesAlong(reference);
  KittiSegmentErrors errors;
  for (std::size_t first = 0; first < reference.size(); first += options.step) {
    for (double length : options.lengths) {
      const auto end =
          std::upper_bound(distance.begin() + first, distance.end(), distance[first] + length);
      if (end == distance.end()) continue;
      const std::size_t last = end - distance.begin();
      const G estimated = estimate[first].Between(estimate[last]);
      const G truth = reference[first].Between(reference[last]);
      const typename G::Tangent d = estimated.LocalCoordinates(truth);
      errors.translation_ratio += d.template head<G::kDim>().norm() / length;
      errors.rotation_rad_per_m += d.template tail<G::kRotationDof>().norm() / length;
      ++errors.segments;
    }
  }
  if (errors.segments > 0) {
    errors.translation_ratio /= errors.segments;
    errors.rotation_rad_per_m /= errors.segments;
  }
  return errors;
}

template Result<KittiSegmentErrors> EvaluateKittiSegments(const std::vector<SE2>&,
                                                          const std::vector<SE2>&,
                                                          const KittiSegmentOptions&);
template Result<KittiSegmentErrors> EvaluateKittiSegments(const std::vector<SE3>&,
                                                          const std::vector<SE3>&,
                                                          const KittiSegmentOptions&);

}  // namespace hpgo
