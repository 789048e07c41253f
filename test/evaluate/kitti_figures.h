// Figures of KITTI sequences that an independent program established.
#pragma once

#include <ostream>
#include <vector>

#include "ceres_costs/se2.h"
#include "gtest/gtest.h"
#include "hpgo/evaluate/kitti_segments.h"
#include "hpgo/evaluate/trajectory_error.h"

namespace hpgo {

struct KittiFigures {
  const char* sequence;
  double translation_ratio, rotation_rad_per_m, ate;
};

// Names a parameterized test's instance.
inline void PrintTo(const KittiFigures& figures, std::ostream* os) { *os << figures.sequence; }

// To 2 %.
inline void ExpectFigures(const KittiFigures& expected,
                          const std::vector<ceres_costs::SE2>& estimate,
                          const std::vector<ceres_costs::SE2>& reference) {
  ASSERT_EQ(estimate.size(), reference.size());
  const auto segments = EvaluateKittiSegments(estimate, reference);
  ASSERT_TRUE(segments.ok()) << segments.status().ToString();
  EXPECT_NEAR(segments->translation_ratio / expected.translation_ratio, 1, 0.02);
  EXPECT_NEAR(segments->rotation_rad_per_m / expected.rotation_rad_per_m, 1, 0.02);
  const auto ate = AbsoluteTrajectoryError(estimate, reference);
  ASSERT_TRUE(ate.ok()) << ate.status().ToString();
  EXPECT_NEAR(ate->translation.rmse / expected.ate, 1, 0.02);
}

}  // namespace hpgo
