// How a Gauss-Newton step that does not lower the cost is shortened and damped.
#pragma once

#include <algorithm>
#include <cmath>

namespace hpgo {

// Of the diagonal of the Hessian.
inline constexpr double kMinDamping = 1e-12;
inline constexpr double kMaxDamping = 1e12;
// Less may make a matrix definite; where a step is too long, a shorter one along it does as well.
inline constexpr double kUsefulDamping = 1e-2;
inline constexpr double kShortestStep = 0.05;  // of the Gauss-Newton step

// Where to end along a step that raised the cost by `rise` and not lowered it by `promised`: what
// the quadratic model misses grows with the third power of the length t, so that the minimum is
// that of -promised (2 t - t^2) + missed t^3.
inline double BestStepLength(double promised, double rise) {
  const double missed = rise + promised;
  return (std::sqrt(promised * (promised + 6 * missed)) - promised) / (3 * missed);
}

// After a step that gained `share` of what it promised: Nielsen's rule, unless the damping was for
// the matrix to be definite.
inline double LessDamping(double damping, double share) {
  if (damping < kUsefulDamping) return damping <= kMinDamping ? 0 : damping / 10;
  const double q = 2 * std::clamp(share, 0., 1.) - 1;
  damping *= std::max(0.1, 1 - q * q * q);
  return damping < kUsefulDamping ? 0 : damping;
}

// More damping, for the step from here to be kShrink times as long: a Newton iteration on
// 1 / |d(damping)| (More and Sorensen, 1983) with lengths |d|^2 = d' D d, D the diagonal of the
// Hessian, and slope = d' D (H + damping D)^-1 D d. The modes that make a step long decide how much
// that is: those of a long chain have eigenvalues of 1e-15 of the diagonal, and an amount that
// suits other graphs would freeze them.
inline double DampingToShrink(double damping, double length_squared, double slope) {
  constexpr double kShrink = 0.3;
  constexpr double kRounding = 1e-15;  // less would be lost in the sum
  const double more = (1 / kShrink - 1) * length_squared / slope;
  return std::max({10 * damping, std::isfinite(more) ? damping + more : 0, kRounding});
}

// For a matrix that was not definite.
inline double DampingToFactorize(double damping) { return std::max(10 * damping, kMinDamping); }

}  // namespace hpgo
