// Robust losses by name.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ceres/loss_function.h"

namespace ceres_costs {

// With s = e' Omega e the squared whitened error and k the scale, every rho(s) ~ s near 0:
//   none           s
//   huber          s up to s = k^2, then 2 k sqrt(s) - k^2: linear in the error
//   cauchy         k^2 log(1 + s / k^2)
//   tukey          k^2 / 3 (1 - (1 - s / k^2)^3) up to s = k^2, then constant: no pull at all
//   geman_mcclure  s / (1 + s / k^2), or "gm": bounded by k^2
//   dcs            s up to s = k, then k (3 s - k) / (s + k), bounded by 3 k: dynamic covariance
//                  scaling, Agarwal et al., ICRA 2013, with Phi = k, a bound on s and not on its
//                  root; its weight rho' is the square of their scale min(1, 2 Phi / (Phi + s))
// Ceres minimizes the sum of rho(s) / 2.
//
// Sets *loss, to null for "none". False with a message, *loss unchanged, for an unknown name or a
// scale that is not a positive finite number ("none" ignores it).
[[nodiscard]] bool MakeLoss(const std::string& name, double scale,
                            std::unique_ptr<ceres::LossFunction>* loss, std::string* error);

// What MakeLoss was called with, "gm" by its long name.
struct LossName {
  std::string name;
  double scale = 0;
};
// Nothing for a loss that MakeLoss has not made.
std::optional<LossName> NameOfLoss(const ceres::LossFunction& loss);

// "none, huber, cauchy, tukey, geman_mcclure (gm), dcs", for help and messages.
const char* LossNames();

}  // namespace ceres_costs
