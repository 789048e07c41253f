#include "hpgo/evaluate/alignment.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "Eigen/SVD"
#include "ceres_costs/finite.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

// Singular values below this share of the positions' spread leave a rotation open.
constexpr double kRankTolerance = 1e-9;

void SetPose(const Eigen::Matrix2d& rotation, const Eigen::Vector2d& t, SE2* pose) {
  *pose = SE2(t(0), t(1), std::atan2(rotation(1, 0), rotation(0, 0)));
}
void SetPose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& t, SE3* pose) {
  *pose = SE3(t, Eigen::Quaterniond(rotation).normalized());
}
void SetPose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& t, YawPose* pose) {
  *pose = YawPose(t(0), t(1), t(2), std::atan2(rotation(1, 0), rotation(0, 0)));
}

// Turns the rotation about `axis` that the positions left open so that the orientations agree best:
// the angle phi that maximizes tr(Exp(phi axis)^T a), a = sum of R_reference (rotation
// R_estimate)^T.
Eigen::Matrix3d TurnAboutLine(const Eigen::Vector3d& axis, const Eigen::Matrix3d& a) {
  const double sine = (ceres_costs::Skew(axis).transpose() * a).trace();
  const double cosine = a.trace() - axis.dot(a * axis);
  return Eigen::AngleAxisd(std::atan2(sine, cosine), axis).toRotationMatrix();
}
Eigen::Matrix2d TurnAboutLine(const Eigen::Vector2d&, const Eigen::Matrix2d&) {
  return Eigen::Matrix2d::Identity();  // a line fixes the rotation of the plane
}

template <int D>
using MatrixD = Eigen::Matrix<double, D, D>;

// The rotation R that maximizes tr(R^T m), and the rank of m as a covariance of that spread.
template <int D>
struct Procrustes {
  Procrustes(const MatrixD<D>& m, double spread)
      : svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV) {
    MatrixD<D> sign = MatrixD<D>::Identity();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign(D - 1, D - 1) = -1;
    rotation = svd.matrixU() * sign * svd.matrixV().transpose();
    while (rank < D && svd.singularValues()(rank) > kRankTolerance * spread) ++rank;
  }
  Eigen::JacobiSVD<MatrixD<D>> svd;
  MatrixD<D> rotation;
  int rank = 0;
};

// The rotation that lays positions on each other, and orientations where they leave it open.
template <int D>
MatrixD<D> FitRotation(const MatrixD<D>& positions, double spread, const MatrixD<D>& orientations) {
  const Procrustes<D> fit(positions, spread);
  if (fit.rank == 0) return Procrustes<D>(orientations, 1.0).rotation;
  if (fit.rank > 1) return fit.rotation;
  const Eigen::Matrix<double, D, 1> axis = fit.svd.matrixU().col(0);
  return TurnAboutLine(axis, MatrixD<D>(orientations * fit.rotation.transpose())) * fit.rotation;
}

template <typename G>
G RigidFit(const std::vector<G>& estimate, const std::vector<G>& reference) {
  constexpr int kDim = G::kDim;
  using Vector = typename G::Vector;
  Vector estimate_mean = Vector::Zero(), reference_mean = Vector::Zero();
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    estimate_mean += estimate[k].translation();
    reference_mean += reference[k].translation();
  }
  estimate_mean /= static_cast<double>(estimate.size());
  reference_mean /= static_cast<double>(estimate.size());

  MatrixD<kDim> positions = MatrixD<kDim>::Zero(), orientations = MatrixD<kDim>::Zero();
  double estimate_spread = 0, reference_spread = 0;
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    const Vector e = estimate[k].translation() - estimate_mean;
    const Vector r = reference[k].translation() - reference_mean;
    positions += r * e.transpose();
    estimate_spread += e.squaredNorm();
    reference_spread += r.squaredNorm();
    orientations += reference[k].matrix() * estimate[k].matrix().transpose();
  }
  // Rounding alone spreads coinciding positions by this much.
  const double magnitude = std::max(estimate_mean.norm(), reference_mean.norm());
  const double rounding = 1e-28 * magnitude * magnitude * static_cast<double>(estimate.size());
  const double spread = std::sqrt(estimate_spread * reference_spread) + rounding / kRankTolerance;

  // About z alone positions turn as in the plane.
  constexpr int kTurned = G::kRotationDof == 1 ? 2 : 3;
  MatrixD<kDim> rotation = MatrixD<kDim>::Identity();
  rotation.template topLeftCorner<kTurned, kTurned>() =
      FitRotation<kTurned>(positions.template topLeftCorner<kTurned, kTurned>(), spread,
                           orientations.template topLeftCorner<kTurned, kTurned>());
  G motion;
  SetPose(rotation, Vector(reference_mean - rotation * estimate_mean), &motion);
  return motion;
}

template <typename G>
Status CheckPoses(const std::vector<G>& estimate, const std::vector<G>& reference) {
  if (estimate.size() != reference.size()) {
    return Status(StatusCode::kInvalidArgument, std::to_string(estimate.size()) +
                                                    " poses to align with " +
                                                    std::to_string(reference.size()));
  }
  if (estimate.empty()) return Status(StatusCode::kInvalidArgument, "no poses to align");
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    if (IsFinite(estimate[k]) && IsFinite(reference[k])) continue;
    return Status(StatusCode::kInvalidArgument,
                  std::string(IsFinite(estimate[k]) ? "reference" : "estimated") + " pose " +
                      std::to_string(k) + " is not finite");
  }
  return Status::Ok();
}

}  // namespace

template <typename G>
Result<G> Align(const std::vector<G>& estimate, const std::vector<G>& reference,
                AlignmentMode mode) {
  if (Status status = CheckPoses(estimate, reference); !status.ok()) return status;
  switch (mode) {
    case AlignmentMode::kIdentity:
      return G();
    case AlignmentMode::kFirstPose:
      return (reference.front() * estimate.front().Inverse()).Normalized();
    case AlignmentMode::kRigid:
      break;
  }
  return RigidFit(estimate, reference);
}

template Result<SE2> Align(const std::vector<SE2>&, const std::vector<SE2>&, AlignmentMode);
template Result<SE3> Align(const std::vector<SE3>&, const std::vector<SE3>&, AlignmentMode);
template Result<YawPose> Align(const std::vector<YawPose>&, const std::vector<YawPose>&,
                               AlignmentMode);

}  // namespace hpgo
