#include "hpgo/report/plot_view.h"

#include <cmath>

#include "gtest/gtest.h"

namespace hpgo {
namespace {

// Points on a box with these half sizes.
PlotGraph BoxGraph(double x, double y, double z) {
  PlotGraph graph;
  graph.is_3d = true;
  for (const double sx : {-1, 1}) {
    for (const double sy : {-1, 1}) {
      for (const double sz : {-1, 1}) graph.positions.emplace_back(sx * x, sy * y, sz * z);
    }
  }
  return graph;
}

TEST(PlotViewTest, A2dGraphIsAMap) {
  PlotGraph graph;
  graph.positions = {{0, 0, 0}, {3, 4, 0}};
  const PlotView view = PlotView::Of(graph);
  EXPECT_EQ(view.Project({3, 4, 0}), Eigen::Vector2d(3, 4));
  const PlotBox box = ProjectedBox(graph, view);
  EXPECT_EQ(box.low, Eigen::Vector2d(0, 0));
  EXPECT_EQ(box.high, Eigen::Vector2d(3, 4));
}

TEST(PlotViewTest, ZPointsUpAndTheViewIsFromAbove) {
  const PlotView view = PlotView::Of(BoxGraph(10, 5, 2));
  const Eigen::Vector2d up = view.Project(Eigen::Vector3d::UnitZ());
  EXPECT_NEAR(up.x(), 0, 1e-12);
  EXPECT_NEAR(up.y(), std::cos(M_PI / 6), 1e-12);
  EXPECT_NEAR(view.Depth(Eigen::Vector3d::UnitZ()), -0.5, 1e-12) << "the top is nearer";
}

TEST(PlotViewTest, TheLongDirectionIsNearTheHorizontal) {
  for (const auto& view : {PlotView::Of(BoxGraph(10, 5, 2)), PlotView::Of(BoxGraph(10, 2, 5))}) {
    EXPECT_GT(std::abs(view.Project(Eigen::Vector3d::UnitX()).x()), 0.9);
  }
}

TEST(PlotViewTest, TheViewKeepsHandedness) {
  const PlotView view = PlotView::Of(BoxGraph(10, 8, 2));
  Eigen::Matrix3d axes;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d unit = Eigen::Vector3d::Unit(k);
    axes.col(k) << view.Project(unit), -view.Depth(unit);
  }
  EXPECT_NEAR(axes.determinant(), 1, 1e-12);
}

TEST(PlotViewTest, ACameraFrameHasMinusYUp) {
  const PlotView view = PlotView::Of(BoxGraph(200, 5, 300));
  EXPECT_GT(view.Project(-Eigen::Vector3d::UnitY()).y(), 0.8);
}

TEST(PlotViewTest, EqualPositionsGiveABoxWithArea) {
  PlotGraph graph;
  graph.is_3d = true;
  graph.positions = {{1, 2, 3}, {1, 2, 3}};
  const PlotBox box = ProjectedBox(graph, PlotView::Of(graph));
  EXPECT_GT(box.size().x(), 0);
  EXPECT_GT(box.size().y(), 0);
  EXPECT_TRUE(box.center().allFinite());
}

}  // namespace
}  // namespace hpgo
