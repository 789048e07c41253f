// Chains that hang on one node alone: nothing pulls at their edges.

#include <vector>

#include "gtest/gtest.h"
#include "hpgo/optimizer.h"

namespace hpgo {
namespace {

template <typename G>
class FreeEndTest : public testing::Test {};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(FreeEndTest, Groups);

// The edge 2 -> 3, bent as a part of a chain, joins 3 -> 4, which was none: where both hang free
// they are what was measured.
TYPED_TEST(FreeEndTest, AnEdgeCutOutOfABentChainIsStraightAgain) {
  using G = TypeParam;
  const typename G::Matrix information = G::Matrix::Identity();
  G step;
  step.translation()(0) = 1;
  Optimizer<G> optimizer;
  std::vector<EdgeId> edges;
  ASSERT_TRUE(optimizer.AddNode(0, G()).ok());
  for (int k = 1; k < 5; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, *optimizer.GetPose(k - 1) * step).ok());
    edges.push_back(*optimizer.AddEdge(k - 1, k, step, information));
  }
  ASSERT_TRUE(optimizer.AddNode(5, *optimizer.GetPose(3) * step).ok());
  ASSERT_TRUE(optimizer.AddEdge(3, 5, step, information).ok());
  typename G::Tangent bend = G::Tangent::Constant(0.3);
  ASSERT_TRUE(optimizer.SetPose(4, optimizer.GetPose(4)->Retract(bend)).ok());
  for (const int k : {0, 4}) ASSERT_TRUE(optimizer.SetFixed(k, true).ok());
  optimizer.Converge();
  ASSERT_GT(optimizer.Cost(), 0.01);

  ASSERT_TRUE(optimizer.RemoveEdge(edges[1]).ok());
  ASSERT_TRUE(optimizer.RemoveNode(5).ok());
  optimizer.Update();
  EXPECT_EQ(optimizer.num_nodes(), 5u);
  EXPECT_LT(optimizer.Cost(), 1e-20);
  EXPECT_EQ(optimizer.FindInconsistency(), "");
}

}  // namespace
}  // namespace hpgo
