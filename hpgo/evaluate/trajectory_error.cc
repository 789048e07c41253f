#include "hpgo/evaluate/trajectory_error.h"

#include <string>

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

template <typename G>
class Collector {
 public:
  // The deviation of one estimated pose or motion from the true one.
  void Add(const G& truth, const G& estimate) {
    const typename G::Tangent d = truth.LocalCoordinates(estimate);
    translation_.push_back(d.template head<G::kDim>().norm());
    rotation_.push_back(d.template tail<G::kRotationDof>().norm());
  }
  TrajectoryError<G> Finish(const G& T_reference_estimate) const {
    return {Summarize(translation_), Summarize(rotation_), T_reference_estimate};
  }

 private:
  std::vector<double> translation_, rotation_;
};

}  // namespace

template <typename G>
Result<TrajectoryError<G>> AbsoluteTrajectoryError(const std::vector<G>& estimate,
                                                   const std::vector<G>& reference,
                                                   AlignmentMode mode) {
  const Result<G> T_reference_estimate = Align(estimate, reference, mode);
  if (!T_reference_estimate.ok()) return T_reference_estimate.status();
  Collector<G> errors;
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    errors.Add(reference[k], *T_reference_estimate * estimate[k]);
  }
  return errors.Finish(*T_reference_estimate);
}

template <typename G>
Result<TrajectoryError<G>> RelativeTrajectoryError(const std::vector<G>& estimate,
                                                   const std::vector<G>& reference, int delta) {
  const Result<G> identity = Align(estimate, reference, AlignmentMode::kIdentity);
  if (!identity.ok()) return identity.status();
  if (delta < 1 || static_cast<std::size_t>(delta) >= estimate.size()) {
    return Status(StatusCode::kInvalidArgument, "no motions over " + std::to_string(delta) +
                                                    " poses in a trajectory of " +
                                                    std::to_string(estimate.size()));
  }
  Collector<G> errors;
  for (std::size_t k = 0; k + delta < estimate.size(); ++k) {
    errors.Add(reference[k].Between(reference[k + delta]),
               estimate[k].Between(estimate[k + delta]));
  }
  return errors.Finish(*identity);
}

template Result<TrajectoryError<SE2>> AbsoluteTrajectoryError(const std::vector<SE2>&,
                                                              const std::vector<SE2>&,
                                                              AlignmentMode);
template Result<TrajectoryError<SE3>> AbsoluteTrajectoryError(const std::vector<SE3>&,
                                                              const std::vector<SE3>&,
                                                              AlignmentMode);
template Result<TrajectoryError<YawPose>> AbsoluteTrajectoryError(const std::vector<YawPose>&,
                                                                  const std::vector<YawPose>&,
                                                                  AlignmentMode);
template Result<TrajectoryError<SE2>> RelativeTrajectoryError(const std::vector<SE2>&,
                                                              const std::vector<SE2>&, int);
template Result<TrajectoryError<SE3>> RelativeTrajectoryError(const std::vector<SE3>&,
                                                              const std::vector<SE3>&, int);
template Result<TrajectoryError<YawPose>> RelativeTrajectoryError(const std::vector<YawPose>&,
                                                                  const std::vector<YawPose>&, int);

}  // namespace hpgo
