// What mappers ask of the optimizer: what has moved since they last asked, and how the map has.

#include <cstddef>
#include <map>
#include <random>
#include <vector>

#include "gtest/gtest.h"
#include "hpgo/optimizer.h"
#include "test/optimizer/mapper_calls_fixture.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

TYPED_TEST_SUITE(MapperCallsTest, MapperCallsGroups);

// A client that applies what it takes holds the optimizer's poses, whatever came between.
TYPED_TEST(MapperCallsTest, CorrectionsAccumulateUntilTaken) {
  for (const double threshold : {0., 0.02}) {
    Optimizer<TypeParam> optimizer;
    EXPECT_TRUE(optimizer.TakeCorrections().moved.empty());
    std::mt19937_64 rng(5);
    std::map<NodeId, TypeParam> held;
    TypeParam truth;
    std::vector<TypeParam> truths;
    std::size_t taken = 0;
    for (int k = 0; k < 120; ++k) {
      truths.push_back(truth);
      TypeParam pose;
      const TypeParam Z =
          k == 0 ? TypeParam()
                 : truths[k - 1].Between(truth) * RandomPose<TypeParam>(&rng, .02, .02);
      if (k > 0) pose = held[k - 1] * Z;
      held[k] = pose;
      ASSERT_TRUE(optimizer.AddNode(k, pose).ok());
      if (k > 0) {
        ASSERT_TRUE(optimizer.AddEdge(k - 1, k, Z, 100 * this->I_).ok());
      }
      if (k > 20 && k % 10 == 0) {
        const TypeParam closure =
            truths[k - 20].Between(truth) * RandomPose<TypeParam>(&rng, .02, .02);
        ASSERT_TRUE(optimizer.AddEdge(k - 20, k, closure, 100 * this->I_).ok());
      }
      optimizer.Update();
      if (k % 7 == 0) {
        const auto corrections = optimizer.TakeCorrections(threshold, threshold);
        taken += corrections.moved.size();
        for (const auto& [id, moved] : corrections.moved) {
          EXPECT_GT(this->Distance(held.at(id), moved), 0);
          held[id] = moved;
        }
        for (const auto& [id, known] : held) {
          EXPECT_LE(this->Distance(known, *optimizer.GetPose(id)), 3 * threshold + 1e-9) << id;
        }
      }
      truth = truth * RandomPose<TypeParam>(&rng, 1, 0.7);
    }
    EXPECT_GT(taken, 50u);
    optimizer.TakeCorrections(threshold, threshold);
    EXPECT_TRUE(optimizer.TakeCorrections(threshold, threshold).moved.empty());
  }
}

// What was posed in the old map moves with the node that was its newest, even if that goes.
TYPED_TEST(MapperCallsTest, TheMotionForWhatIsPosedInTheOldMap) {
  auto& optimizer = this->optimizer_;
  TypeParam step;
  step.translation()(0) = 1;
  for (int k = 0; k < 6; ++k) {
    ASSERT_TRUE(optimizer.AddNode(k, k == 0 ? TypeParam() : *optimizer.GetPose(k - 1) * step).ok());
    if (k > 0) {
      ASSERT_TRUE(optimizer.AddEdge(k - 1, k, step, this->I_).ok());
    }
  }
  optimizer.Update();
  EXPECT_LT(this->Distance(optimizer.TakeCorrections().motion, TypeParam()), 1e-12);
  const TypeParam before = *optimizer.GetPose(5);
  typename TypeParam::Tangent turn = TypeParam::Tangent::Zero();
  turn(TypeParam::kDof - 1) = 0.4;
  ASSERT_TRUE(optimizer.AddEdge(0, 5, before.Retract(turn), 10 * this->I_).ok());
  optimizer.Refine();
  const TypeParam motion = *optimizer.GetPose(5) * before.Inverse();
  EXPECT_GT(this->Distance(motion, TypeParam()), 0.1);
  ASSERT_TRUE(optimizer.RemoveNode(5).ok());
  // The node that it was measured from stands for it from then on.
  const TypeParam at_removal = *optimizer.GetPose(4);
  ASSERT_TRUE(optimizer.SetPose(4, at_removal.Retract(turn)).ok());
  const TypeParam later = *optimizer.GetPose(4) * at_removal.Inverse();
  EXPECT_LT(this->Distance(optimizer.TakeCorrections().motion, later * motion), 1e-9);
  EXPECT_LT(this->Distance(optimizer.TakeCorrections().motion, TypeParam()), 1e-9);
}

// Without an edge, the newest node that there is stands for it.
TYPED_TEST(MapperCallsTest, TheMotionOfANodeThatGoesWithoutEdges) {
  auto& optimizer = this->optimizer_;
  ASSERT_TRUE(optimizer.AddNode(0, TypeParam()).ok());
  ASSERT_TRUE(optimizer.AddNode(1, TypeParam()).ok());
  optimizer.TakeCorrections();
  const TypeParam motion = RandomPose<TypeParam>(&this->rng_, 1, 1);
  ASSERT_TRUE(optimizer.SetPose(1, motion).ok());
  ASSERT_TRUE(optimizer.AddNode(2, TypeParam()).ok());
  ASSERT_TRUE(optimizer.RemoveNode(1).ok());
  EXPECT_LT(this->Distance(optimizer.TakeCorrections().motion, motion), 1e-9);
}

TYPED_TEST(MapperCallsTest, TheFirstCorrectionsAreAllPoses) {
  auto& optimizer = this->optimizer_;
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(optimizer.AddNode(k, TypeParam()).ok());
  EXPECT_EQ(optimizer.TakeCorrections().moved.size(), 3u);
  EXPECT_TRUE(optimizer.TakeCorrections().moved.empty());
}

}  // namespace
}  // namespace hpgo
