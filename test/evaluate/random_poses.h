// Random poses for the tests of this folder.
#pragma once

#include <random>
#include <vector>

#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace hpgo {

template <typename G>
G RandomPose(std::mt19937_64* rng, double size = 10.0) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  typename G::Tangent d;
  for (int k = 0; k < G::kDof; ++k) d(k) = uniform(*rng) * (k < G::kDim ? size : 1.8);
  return G().Retract(d);
}

template <typename G>
std::vector<G> RandomPoses(std::mt19937_64* rng, int count) {
  std::vector<G> poses;
  for (int k = 0; k < count; ++k) poses.push_back(RandomPose<G>(rng));
  return poses;
}

// Every pose moved by `T` on the left: the same trajectory in another frame.
template <typename G>
std::vector<G> Moved(const G& T, const std::vector<G>& poses) {
  std::vector<G> moved;
  for (const G& pose : poses) moved.push_back(T * pose);
  return moved;
}

// A random symmetric positive definite matrix, dense.
template <typename G>
typename G::Matrix RandomInformation(std::mt19937_64* rng) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  typename G::Matrix a;
  for (int k = 0; k < a.size(); ++k) a.data()[k] = uniform(*rng);
  return a * a.transpose() + G::Matrix::Identity();
}

}  // namespace hpgo
