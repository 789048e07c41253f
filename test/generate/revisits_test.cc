#include "hpgo/generate/revisits.h"

#include <algorithm>
#include <cmath>

#include "gtest/gtest.h"
#include "hpgo/generate/random.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// A walk that often comes back: short steps in a small box.
template <typename G>
std::vector<G> Walk(int count) {
  Random random(9, 0);
  std::vector<G> poses(1);
  for (int k = 1; k < count; ++k) {
    G pose = poses.back();
    for (int c = 0; c < G::kDim; ++c) {
      pose.translation()(c) = std::clamp(pose.translation()(c) + random.Uniform(-1, 1), -5.0, 5.0);
    }
    poses.push_back(pose);
  }
  return poses;
}

template <typename G>
class RevisitsTest : public ::testing::Test {};
using Groups = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(RevisitsTest, Groups, );

TYPED_TEST(RevisitsTest, PairsEveryNodeWithItsNearestOlderPass) {
  const auto poses = Walk<TypeParam>(400);
  RevisitOptions options;
  options.radius = 1.0;
  options.min_travel = 4;
  options.max_per_node = 1;
  std::vector<int> expected(poses.size(), -1);
  std::vector<double> travelled(poses.size(), 0.0);
  int revisits = 0;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    travelled[k] = travelled[k - 1] + (poses[k].translation() - poses[k - 1].translation()).norm();
    double nearest = options.radius;
    for (std::size_t older = 0; older < k; ++older) {
      const double d = (poses[k].translation() - poses[older].translation()).norm();
      if (travelled[k] - travelled[older] < options.min_travel || d > nearest) continue;
      nearest = d;
      expected[k] = static_cast<int>(older);
    }
    revisits += expected[k] >= 0;
  }
  const std::vector<Revisit> found = FindRevisits(poses, options);
  EXPECT_EQ(found.size(), static_cast<std::size_t>(revisits));
  EXPECT_GT(revisits, 50);
  for (const Revisit& revisit : found) EXPECT_EQ(expected[revisit.newer], revisit.older);
}

TYPED_TEST(RevisitsTest, EachPassOnce) {
  // Round and round a square of 20 m, 1 m a step, 5 times.
  std::vector<TypeParam> poses;
  for (int k = 0; k < 400; ++k) {
    const int side = k % 80 / 20, along = k % 20;
    TypeParam pose;
    pose.translation()(0) = side == 0 ? along : side == 1 ? 20 : side == 2 ? 20 - along : 0;
    pose.translation()(1) = side == 0 ? 0 : side == 1 ? along : side == 2 ? 20 : 20 - along;
    poses.push_back(pose);
  }
  RevisitOptions options;
  options.max_per_node = 10;
  std::vector<int> count(poses.size(), 0);
  for (const Revisit& revisit : FindRevisits(poses, options)) {
    ++count[revisit.newer];
    if (revisit.newer % 80 == 79) continue;  // the end of a lap also sees the start of it
    EXPECT_EQ((revisit.newer - revisit.older) % 80, 0) << "the same place is the nearest";
  }
  for (int k = 10; k < 75; ++k) EXPECT_EQ(count[k], 0) << k;
  for (int k = 85; k < 400; ++k) EXPECT_EQ(count[k], k / 80 + (k % 80 == 79 ? 1 : 0)) << k;
}

TEST(RevisitsTest, StandingStillIsNoRevisit) {
  const std::vector<SE2> poses(20000);
  EXPECT_TRUE(FindRevisits(poses, RevisitOptions()).empty());
}

}  // namespace
}  // namespace hpgo
