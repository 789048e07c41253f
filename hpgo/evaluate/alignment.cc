#include "hpgo/evaluate/alignment.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "Eigen/SVD"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// Singular values below this share of the positions' spread leave a rotation open.
constexpr double kRankTolerance = 1e-9;

SE2 MakePose(const Eigen::Matrix2d& rotation, const Eigen::Vector2d& t) {
  return SE2(t(0), t(1), std::atan2(rotation(1, 0), rotation(0, 0)));
}
SE3 MakePose(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& t) {
  return SE3(t, Eigen::Quaterniond(rotation).normalized());
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

  const Procrustes<kDim> fit(positions, spread);
  MatrixD<kDim> rotation = fit.rotation;
  if (fit.rank == 0) {
    rotation = Procrustes<kDim>(orientations, 1.0).rotation;
  } else if (fit.rank == 1) {
    const Vector axis = fit.svd.matrixU().col(0);
    rotation = TurnAboutLine(axis, MatrixD<kDim>(orientations * rotation.transpose())) * rotation;
  }
  return MakePose(rotation, Vector(reference_mean - rotation * estimate_mean));
}

template <typename G>
bool IsFinite(const G& pose) {
  for (int k = 0; k < G::kParams; ++k) {
    if (!std::isfinite(pose.data()[k])) return false;
  }
  return true;
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

}  // namespace hpgo
