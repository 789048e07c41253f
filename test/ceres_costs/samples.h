// Poses, tangents and information matrices that the tests of the costs share, and matchers in which
// nan fails.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "Eigen/Core"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"
#include "gtest/gtest.h"

namespace ceres_costs {

inline constexpr double kPi = 3.14159265358979323846;

// Every entry within `tolerance` of the other's.
template <typename A, typename B>
testing::AssertionResult IsNear(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b,
                                double tolerance) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) {
    return testing::AssertionFailure() << "sizes differ";
  }
  for (int r = 0; r < a.rows(); ++r) {
    for (int c = 0; c < a.cols(); ++c) {
      if (std::abs(a(r, c) - b(r, c)) <= tolerance) continue;
      return testing::AssertionFailure()
             << "entry (" << r << ", " << c << ") differs by " << std::abs(a(r, c) - b(r, c))
             << " > " << tolerance << ":\n"
             << a << "\nagainst\n"
             << b;
    }
  }
  return testing::AssertionSuccess();
}

// The pose with one stored parameter replaced.
template <typename G>
G WithParameter(const G& pose, int k, double value) {
  double params[G::kParams];
  std::copy_n(pose.data(), G::kParams, params);
  params[k] = value;
  return G(params);
}

// The same rigid transform; quaternions of either sign.
template <typename G>
testing::AssertionResult IsSamePose(const G& a, const G& b, double tolerance) {
  const testing::AssertionResult rotation = IsNear(a.matrix(), b.matrix(), tolerance);
  if (!rotation) return rotation;
  const double scale = 1 + a.translation().norm();
  return IsNear(a.translation(), b.translation(), tolerance * scale);
}

inline SE2::Tangent MakeTangent(const SE2*, double distance, double angle) {
  return SE2::Tangent(0.6 * distance, -0.8 * distance, angle);
}
inline SE3::Tangent MakeTangent(const SE3*, double distance, double angle) {
  SE3::Tangent d;
  d << 0.48 * distance, -0.64 * distance, 0.6 * distance, 2.0 / 7 * angle, 3.0 / 7 * angle,
      -6.0 / 7 * angle;
  return d;
}
inline YawPose::Tangent MakeTangent(const YawPose*, double distance, double angle) {
  return YawPose::Tangent(0.48 * distance, -0.64 * distance, 0.6 * distance, angle);
}

// Tangents at identity, tiny, on both sides of every switch to a series, near +-pi (as near as
// `pi_margin`) and large; distances from 0 to 1e3.
template <typename G>
std::vector<typename G::Tangent> SampleTangents(double pi_margin) {
  std::vector<typename G::Tangent> samples;
  for (const double angle : {0.0, 1e-12, 1e-9, 2e-6, 1e-4, 1.1e-4, 0.0099, 0.0101, 0.0999, 0.1001,
                             0.7, 2.5, kPi - 1e-3, kPi - pi_margin}) {
    for (const double distance : {0.0, 1e-9, 1.0, 1e3}) {
      samples.push_back(MakeTangent(static_cast<const G*>(nullptr), distance, angle));
      samples.push_back(MakeTangent(static_cast<const G*>(nullptr), distance, -angle));
    }
  }
  return samples;
}

template <typename G>
std::vector<G> SamplePoses(double pi_margin) {
  std::vector<G> poses;
  for (const auto& d : SampleTangents<G>(pi_margin)) poses.push_back(G().Retract(d));
  return poses;
}

template <typename G>
G RandomPose(std::mt19937* rng, double distance) {
  std::uniform_real_distribution<double> unit(-1, 1);
  typename G::Tangent d;
  for (int k = 0; k < G::kDof; ++k) d(k) = unit(*rng);
  d.template head<G::kDim>() *= distance;
  d.template tail<G::kRotationDof>() *= 1.7;
  return G().Retract(d);
}

// Dense and positive definite, of eigenvalues from about 0.1 to 10 and `rank` of them not zero.
template <int N>
Eigen::Matrix<double, N, N> RandomInformation(std::mt19937* rng, int rank = N) {
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, N, N> m = Eigen::Matrix<double, N, N>::Zero();
  for (int k = 0; k < rank; ++k) {
    Eigen::Matrix<double, N, 1> v;
    for (int r = 0; r < N; ++r) v(r) = normal(*rng);
    m += v * v.transpose();
    if (rank == N) m(k, k) += 0.1;
  }
  return m;
}

}  // namespace ceres_costs
