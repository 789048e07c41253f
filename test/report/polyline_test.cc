#include "hpgo/report/polyline.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace hpgo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(SimplifyPolylineTest, KeepsTheEndsOfAStraightLine) {
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k <= 10; ++k) points.emplace_back(k, 2 * k);
  EXPECT_THAT(SimplifyPolyline(points, 0.01), ElementsAre(0, 10));
}

TEST(SimplifyPolylineTest, KeepsACorner) {
  EXPECT_THAT(SimplifyPolyline({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {2, 2}}, 0.1),
              ElementsAre(0, 2, 4));
}

TEST(SimplifyPolylineTest, KeepsATurnBackOnTheSameLine) {
  EXPECT_THAT(SimplifyPolyline({{0, 0}, {5, 0}, {1, 0}}, 0.1), ElementsAre(0, 1, 2));
}

TEST(SimplifyPolylineTest, HandlesFewPoints) {
  EXPECT_THAT(SimplifyPolyline({}, 1), IsEmpty());
  EXPECT_THAT(SimplifyPolyline({{1, 1}}, 1), ElementsAre(0));
  EXPECT_THAT(SimplifyPolyline({{1, 1}, {1, 1}}, 1), ElementsAre(0, 1));
}

TEST(SimplifyPolylineTest, NoPointIsFartherThanTheTolerance) {
  constexpr double kTolerance = 0.3;
  std::vector<Eigen::Vector2d> points;
  for (int k = 0; k < 20000; ++k) {
    const double t = 0.01 * k;
    points.emplace_back(t * std::cos(t), t * std::sin(t));
  }
  const std::vector<int> kept = SimplifyPolyline(points, kTolerance);
  EXPECT_LT(kept.size(), 2000u);
  double worst = 0;
  for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
    const Eigen::Vector2d from = points[kept[k]];
    const Eigen::Vector2d along = (points[kept[k + 1]] - from).normalized();
    for (int p = kept[k]; p <= kept[k + 1]; ++p) {
      const Eigen::Vector2d d = points[p] - from;
      worst = std::max(worst, std::abs(along.x() * d.y() - along.y() * d.x()));
    }
  }
  EXPECT_GT(worst, 0);
  EXPECT_LE(worst, kTolerance);
}

}  // namespace
}  // namespace hpgo
