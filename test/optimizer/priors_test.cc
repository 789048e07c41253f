// Measurements of single poses, whole and partial.

#include <map>
#include <random>

#include "gtest/gtest.h"
#include "test/optimizer/oracle.h"
#include "test/solve/small_graphs.h"

namespace hpgo {
namespace {

template <typename G>
class PriorsTest : public testing::Test {
 protected:
  using Information = typename G::Matrix;
  using Weights = typename G::Tangent;

  // A loop of ten exact edges, away from the truth by `away`.
  void Build(const G& away) {
    G pose;
    for (int k = 0; k < 10; ++k) {
      truth_[k] = pose;
      EXPECT_TRUE(optimizer_.AddNode(k, away * pose).ok());
      pose = pose * RandomPose<G>(&rng_, 2, 0.8);
    }
    for (int k = 0; k < 10; ++k) {
      const int next = (k + 1) % 10;
      const G Z = truth_[k].Between(truth_[next]);
      EXPECT_TRUE(optimizer_.AddEdge(k, next, Z, 100 * Information::Identity()).ok());
    }
    optimizer_.Update();
  }
  void AddPrior(NodeId id, const Weights& weights, const G& offset) {
    const Information information = weights.asDiagonal();
    EXPECT_TRUE(optimizer_.AddPrior(id, truth_[id] * offset, information, offset).ok());
  }
  double LargestError() {
    double largest = 0;
    for (const auto& [id, pose] : truth_) {
      largest = std::max(largest, pose.LocalCoordinates(*optimizer_.GetPose(id)).norm());
    }
    return largest;
  }
  static Weights PositionOnly() {
    Weights weights = Weights::Ones();
    weights.template tail<G::kRotationDof>().setZero();
    return weights;
  }

  std::mt19937_64 rng_{5};
  std::map<NodeId, G> truth_;
  Optimizer<G> optimizer_;
};
using Groups = testing::Types<SE2, SE3, YawPose>;
TYPED_TEST_SUITE(PriorsTest, Groups);

TYPED_TEST(PriorsTest, AFullPriorBringsTheMapHome) {
  this->Build(RandomPose<TypeParam>(&this->rng_, 3, 0.5));
  this->AddPrior(4, TypeParam::Tangent::Ones(), TypeParam());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->LargestError(), 1e-4);
}

TYPED_TEST(PriorsTest, AnOffsetIsThatOfTheSensorOnTheNode) {
  this->Build(RandomPose<TypeParam>(&this->rng_, 3, 0.5));
  this->AddPrior(4, TypeParam::Tangent::Ones(), RandomPose<TypeParam>(&this->rng_, 2, 2));
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->LargestError(), 1e-4);
}

TYPED_TEST(PriorsTest, PositionsAloneFixThePose) {
  this->Build(RandomPose<TypeParam>(&this->rng_, 3, 0.5));
  for (int k = 0; k < 10; k += 2) this->AddPrior(k, this->PositionOnly(), TypeParam());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->LargestError(), 1e-3);
}

// Antennas: what the lever arm tells of the attitude is used.
TYPED_TEST(PriorsTest, PositionsOfSensorsOffTheNode) {
  this->Build(RandomPose<TypeParam>(&this->rng_, 3, 0.5));
  for (int k = 0; k < 10; k += 2) {
    this->AddPrior(k, this->PositionOnly(), RandomPose<TypeParam>(&this->rng_, 2, 2));
  }
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->LargestError(), 1e-3);
}

TYPED_TEST(PriorsTest, OnePositionTurnsNothing) {
  const TypeParam away = RandomPose<TypeParam>(&this->rng_, 3, 0.5);
  this->Build(away);
  this->AddPrior(4, this->PositionOnly(), TypeParam());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->optimizer_.Cost(), 1e-8);
  EXPECT_LT((this->optimizer_.GetPose(4)->translation() - this->truth_[4].translation()).norm(),
            1e-4);
}

TYPED_TEST(PriorsTest, AnAttitudeMovesNoPosition) {
  const TypeParam away = RandomPose<TypeParam>(&this->rng_, 3, 0.5);
  this->Build(away);
  typename TypeParam::Tangent weights = TypeParam::Tangent::Ones();
  weights.template head<TypeParam::kDim>().setZero();
  this->AddPrior(4, weights, TypeParam());
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->optimizer_.Cost(), 1e-8);
  for (int k = 0; k < 10; ++k) {  // every heading is right
    const auto error = this->truth_[k].LocalCoordinates(*this->optimizer_.GetPose(k));
    EXPECT_LT(error.template tail<TypeParam::kRotationDof>().norm(), 1e-3) << k;
  }
}

// Map coordinates of millions of metres need no shift of the origin.
TYPED_TEST(PriorsTest, FarFromTheOrigin) {
  TypeParam utm;
  utm.translation()(0) = 5.1e5;
  utm.translation()(1) = 5.4e6;
  this->Build(RandomPose<TypeParam>(&this->rng_, 3, 0.5));
  for (int k = 0; k < 10; k += 2) {
    const typename TypeParam::Matrix information = this->PositionOnly().asDiagonal();
    ASSERT_TRUE(this->optimizer_.AddPrior(k, utm * this->truth_[k], information).ok());
  }
  for (auto& [id, pose] : this->truth_) pose = utm * pose;
  EXPECT_TRUE(this->optimizer_.Refine().at_rest);
  EXPECT_LT(this->LargestError(), 1e-3);
}

TYPED_TEST(PriorsTest, OfAnUnnormalizedQuaternionAreTheSame) {
  if constexpr (TypeParam::kRotationDof == 3) {
    this->Build(RandomPose<TypeParam>(&this->rng_, 3, 0.5));
    TypeParam offset = RandomPose<TypeParam>(&this->rng_, 2, 2);
    TypeParam measurement = this->truth_[4] * offset;
    for (int k = 3; k < 7; ++k) offset.data()[k] *= 2;
    for (int k = 3; k < 7; ++k) measurement.data()[k] *= 3;
    const typename TypeParam::Matrix I = TypeParam::Matrix::Identity();
    ASSERT_TRUE(this->optimizer_.AddPrior(4, measurement, I, offset).ok());
    EXPECT_TRUE(this->optimizer_.Refine().at_rest);
    EXPECT_LT(this->LargestError(), 1e-4);
  }
}

TYPED_TEST(PriorsTest, ChangedAndRemoved) {
  this->Build(TypeParam());
  const typename TypeParam::Matrix I = TypeParam::Matrix::Identity();
  const EdgeId prior = *this->optimizer_.AddPrior(4, this->truth_[4], I);
  this->optimizer_.Refine();
  const TypeParam there = RandomPose<TypeParam>(&this->rng_, 3, 0.5) * this->truth_[4];
  ASSERT_TRUE(this->optimizer_.UpdateEdge(prior, there, I).ok());
  this->optimizer_.Refine();
  EXPECT_LT(there.LocalCoordinates(*this->optimizer_.GetPose(4)).norm(), 1e-4);
  ASSERT_TRUE(this->optimizer_.RemoveEdge(prior).ok());
  this->optimizer_.Refine();
  EXPECT_LT(there.LocalCoordinates(*this->optimizer_.GetPose(4)).norm(), 1e-4);  // stays
  EXPECT_LT(this->optimizer_.Cost(), 1e-8);
}

}  // namespace
}  // namespace hpgo
