#include "hpgo/solve/over_correction.h"

#include "gtest/gtest.h"
#include "small_graphs.h"
#include "small_hierarchies.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;

// A chain on three levels or more, held at its first node.
template <typename G>
class OverCorrectionTest : public testing::Test {
 protected:
  OverCorrectionTest() {
    PoseGraph<G> graph;
    std::mt19937_64 rng(7);
    constexpr int kNodes = 60;
    for (int k = 0; k < kNodes; ++k) {
      GraphNode<G> node;
      node.id = k;
      node.pose = RandomPose<G>(&rng, 5, 2);
      node.fixed = k == 0;
      EXPECT_TRUE(graph.AddNode(node).ok());
      if (k == 0) continue;
      GraphEdge<G> edge;
      edge.i = k - 1;
      edge.j = k;
      edge.measurement = graph.nodes()[k - 1].pose.Between(node.pose);
      edge.information.setIdentity();
      EXPECT_TRUE(graph.AddEdge(edge).ok());
    }
    HierarchyOptions options;
    options.max_top_nodes = 8;
    hierarchy_ = MakeHierarchy(graph, options);
    top_ = hierarchy_.num_levels() - 1;
    EXPECT_GE(top_, 2);
  }

  // The factor of a window of the whole level whose solution moves every node by `distance`, and
  // moves them as told.
  double Move(int l, double distance) {
    EXPECT_TRUE(window_.BuildWhole(l, &hierarchy_));
    for (int k = 0; k < window_.num_free(); ++k) {
      window_.subproblem().poses[k].translation()(0) += distance;
    }
    const double factor = over_correction_.Factor(window_, hierarchy_);
    window_.Stretch(factor);
    EXPECT_NEAR(window_.Displacement(0)(0), factor * distance, 1e-9);
    window_.Commit(&hierarchy_);
    return factor;
  }

  Hierarchy<G> hierarchy_;
  int top_ = 0;
  Window<G> window_;
  OverCorrection<G> over_correction_;
};

using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(OverCorrectionTest, Groups);

TYPED_TEST(OverCorrectionTest, NothingIsKnownAtFirst) { EXPECT_EQ(this->Move(this->top_, 1), 1); }

TYPED_TEST(OverCorrectionTest, LearnsTheFactorFromTheNextMotion) {
  // A solution finds 1 / 1.5 of what is needed: 3 m.
  EXPECT_EQ(this->Move(this->top_, 2), 1);
  EXPECT_NEAR(this->Move(this->top_, 1 / 1.5), 1.5, 1e-9);
  // That was all; a little the other way is not yet a reason to fall short.
  EXPECT_NEAR(this->Move(this->top_, 0), 1.5, 1e-9);
}

TYPED_TEST(OverCorrectionTest, GoesNoFurtherThanTheSolutionWhereThatIsEnough) {
  EXPECT_EQ(this->Move(this->top_, 1), 1);
  EXPECT_EQ(this->Move(this->top_, -0.2), 1);
}

TYPED_TEST(OverCorrectionTest, IsBounded) {
  EXPECT_EQ(this->Move(this->top_, 1), 1);
  for (int k = 0; k < 3; ++k) {
    const double factor = this->Move(this->top_, 10);
    EXPECT_GT(factor, 1.5);
    EXPECT_LT(factor, 2);
  }
}

TYPED_TEST(OverCorrectionTest, ALevelAsksTheOneAboveFirst) {
  EXPECT_EQ(this->Move(this->top_, 1), 1);
  EXPECT_NEAR(this->Move(this->top_ - 1, 0.3), 1.3, 1e-9);
  EXPECT_NEAR(this->Move(this->top_ - 2, 0), 1, 1e-9);
}

TYPED_TEST(OverCorrectionTest, Forgets) {
  EXPECT_EQ(this->Move(this->top_, 1), 1);
  this->over_correction_.Forget();
  EXPECT_EQ(this->Move(this->top_, 1), 1);
}

}  // namespace
}  // namespace hpgo
