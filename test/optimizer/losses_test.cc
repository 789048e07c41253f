// A loss of its own for every edge: as many as there are edges, each freed with its edge.

#include <memory>
#include <utility>
#include <vector>

#include "ceres/loss_function.h"
#include "gtest/gtest.h"
#include "hpgo/hierarchy/consistency.h"
#include "hpgo/optimizer.h"

namespace hpgo {
namespace {

template <typename G>
class LossesTest : public testing::Test {
 protected:
  static G Step(double length) {
    G step;
    step.translation()(0) = length;
    return step;
  }
};
using Groups = testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(LossesTest, Groups);

TYPED_TEST(LossesTest, TenThousandOfThem) {
  using Information = typename TypeParam::Matrix;
  constexpr int kEdges = 10000;
  Optimizer<TypeParam> optimizer;
  std::vector<std::weak_ptr<ceres::HuberLoss>> losses;
  std::vector<EdgeId> ids;
  ASSERT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
  for (int k = 1; k <= kEdges; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, this->Step(k)).ok());
    auto loss = std::make_shared<ceres::HuberLoss>(k);
    losses.push_back(loss);
    // Off by 2 k: of rho's linear part, 2 k sqrt(s) - k^2.
    ids.push_back(*optimizer.AddEdge(k - 1, k, this->Step(1 + 2 * k), Information::Identity(),
                                     std::move(loss)));
  }
  double cost = 0;
  for (double k = 1; k <= kEdges; ++k) cost += 3 * k * k;
  EXPECT_NEAR(optimizer.Cost(), cost, 1e-9 * cost);
  EXPECT_TRUE(optimizer.Update().status.ok());
  for (int k = 0; k < kEdges; ++k) {
    ASSERT_FALSE(losses[k].expired()) << k;
    ASSERT_TRUE(optimizer.RemoveEdge(ids[k]).ok());
    ASSERT_TRUE(losses[k].expired()) << k;
  }
  EXPECT_EQ(FindInconsistency(optimizer.hierarchy()), "");
}

TYPED_TEST(LossesTest, AreFreedWithTheNodeAndTheOptimizer) {
  using Information = typename TypeParam::Matrix;
  const auto loss = std::make_shared<ceres::CauchyLoss>(1);
  {
    Optimizer<TypeParam> optimizer;
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(optimizer.AddNode(k, this->Step(k)).ok());
    const Information I = Information::Identity();
    ASSERT_TRUE(optimizer.AddEdge(0, 1, this->Step(1), I, loss).ok());
    ASSERT_TRUE(optimizer.AddEdge(1, 2, this->Step(1), I, loss).ok());
    ASSERT_TRUE(optimizer.AddPrior(2, this->Step(2), I, TypeParam(), loss).ok());
    EXPECT_EQ(loss.use_count(), 4);
    ASSERT_TRUE(optimizer.RemoveNode(2).ok());
    EXPECT_EQ(loss.use_count(), 2);
    // Its place is used again, without the loss.
    ASSERT_TRUE(optimizer.AddNode(2, this->Step(2)).ok());
    ASSERT_TRUE(optimizer.AddEdge(1, 2, this->Step(3), I).ok());
    EXPECT_EQ(optimizer.Cost(), 4);
    EXPECT_EQ(loss.use_count(), 2);
  }
  EXPECT_EQ(loss.use_count(), 1);
}

TYPED_TEST(LossesTest, CostNothingWhereThereAreNone) {
  using Information = typename TypeParam::Matrix;
  const auto bytes = [&](bool with_losses) {
    OptimizerOptions options;
    options.condense_chains = false;
    Optimizer<TypeParam> optimizer(options);
    EXPECT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
    for (int k = 1; k < 3000; ++k) {
      EXPECT_TRUE(optimizer.AddNode(k, this->Step(k)).ok());
      const auto loss = with_losses ? std::make_shared<ceres::HuberLoss>(1) : nullptr;
      EXPECT_TRUE(optimizer.AddEdge(k - 1, k, this->Step(1), Information::Identity(), loss).ok());
    }
    optimizer.Update();
    return optimizer.MemoryBytes();
  };
  EXPECT_LE(sizeof(LevelEdge), 88u);
  // Three shared pointers each, in whole chunks.
  EXPECT_EQ(bytes(true) - bytes(false), 3 * 1024 * 6 * sizeof(void*));
}

}  // namespace
}  // namespace hpgo
