#include "ceres_costs/whitening.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "ceres_costs/packed_symmetric.h"
#include "test/ceres_costs/samples.h"

namespace ceres_costs {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

TEST(PackedSymmetricTest, HoldsTheUpperTriangleRowByRow) {
  Matrix3d m;
  m << 1, 2, 3, 2, 4, 5, 3, 5, 6;
  const PackedSymmetric<3> packed(m);
  for (int k = 0; k < 6; ++k) EXPECT_EQ(packed.data()[k], k + 1);
  EXPECT_EQ(packed.Dense(), m);
  EXPECT_EQ(PackedSymmetric<6>().Dense(), Matrix6d::Zero());
}

// The trap: with Omega = L L', |L e|^2 is e' L' L e, another number.
TEST(WhitenInformationTest, WhitensWithTheTransposedFactor) {
  Matrix2d information;
  information << 4, 2, 2, 2;  // L = [2 0; 1 1]
  Matrix2d W;
  ASSERT_TRUE(WhitenInformation<2>(information, &W));
  EXPECT_TRUE(IsNear(W, (Matrix2d() << 2, 1, 0, 1).finished(), 1e-15));
  const Eigen::Vector2d e(1, -3);
  EXPECT_NEAR((W * e).squaredNorm(), 10, 1e-14);             // e' Omega e
  EXPECT_NEAR((W.transpose() * e).squaredNorm(), 8, 1e-14);  // what L would give
}

template <int N>
void ExpectSquareIsInformation(const Eigen::Matrix<double, N, N>& information, double tolerance) {
  Eigen::Matrix<double, N, N> W;
  ASSERT_TRUE(WhitenInformation<N>(information, &W)) << information;
  EXPECT_TRUE(IsNear(W.transpose() * W, information, tolerance));
}

TEST(WhitenInformationTest, SquareIsTheInformation) {
  std::mt19937 rng(1);
  for (int k = 0; k < 20; ++k) {
    ExpectSquareIsInformation<2>(RandomInformation<2>(&rng), 1e-13);
    ExpectSquareIsInformation<3>(RandomInformation<3>(&rng), 1e-13);
    ExpectSquareIsInformation<6>(RandomInformation<6>(&rng), 1e-13);
  }
}

TEST(WhitenInformationTest, SquareIsTheInformationWhereItIsSingular) {
  std::mt19937 rng(2);
  for (int k = 0; k < 20; ++k) {
    for (int rank = 0; rank < 6; ++rank) {
      const Matrix6d information = RandomInformation<6>(&rng, rank);
      ExpectSquareIsInformation<6>(information, 1e-13 * (1 + information.norm()));
    }
    ExpectSquareIsInformation<3>(RandomInformation<3>(&rng, 2), 1e-13);
  }
}

TEST(WhitenInformationTest, WhatIsNotMeasuredHasNoWeightAtAll) {
  std::mt19937 rng(3);
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>() = RandomInformation<3>(&rng);
  information.row(1).setZero();
  information.col(1).setZero();
  Matrix6d W;
  ASSERT_TRUE(WhitenInformation<6>(information, &W));
  EXPECT_TRUE(IsNear(W.transpose() * W, information, 1e-14));
  EXPECT_EQ(W.col(1).norm(), 0);
  EXPECT_EQ(W.rightCols<3>().norm(), 0);
}

TEST(WhitenInformationTest, WeakDirectionsKeepTheirDigitsBesideStrongOnes) {
  Matrix3d information = Matrix3d::Zero();
  information.topLeftCorner<2, 2>() << 1e14, 0.5e3, 0.5e3, 1e-7;  // correlation 0.16; last: none
  Matrix3d W;
  ASSERT_TRUE(WhitenInformation<3>(information, &W));
  const Matrix3d square = W.transpose() * W;
  EXPECT_NEAR(square(0, 0), 1e14, 1);
  EXPECT_NEAR(square(0, 1), 0.5e3, 1e-11);
  EXPECT_NEAR(square(1, 1), 1e-7, 1e-21);
}

TEST(WhitenInformationTest, RefusesIndefiniteAndNotFinite) {
  const Matrix3d untouched = Matrix3d::Constant(7);
  Matrix3d W = untouched;
  EXPECT_FALSE(WhitenInformation<3>(Eigen::Vector3d(1, 1, -1e-6).asDiagonal(), &W));
  EXPECT_FALSE(WhitenInformation<3>(-Matrix3d::Identity(), &W));
  for (const double bad : {kNan, kInf, -kInf}) {
    for (int r = 0; r < 3; ++r) {
      for (int c = r; c < 3; ++c) {
        Matrix3d information = Matrix3d::Identity();
        information(r, c) = bad;
        EXPECT_FALSE(WhitenInformation<3>(information, &W));
      }
    }
  }
  EXPECT_EQ(W, untouched);
}

TEST(WhitenInformationTest, ReadsTheUpperTriangleAlone) {
  Matrix3d information;
  information << 2, 1, 0.5, kNan, 2, 0.25, -9, kInf, 2;
  Matrix3d expected;
  expected << 2, 1, 0.5, 1, 2, 0.25, 0.5, 0.25, 2;
  Matrix3d W;
  ASSERT_TRUE(WhitenInformation<3>(information, &W));
  EXPECT_TRUE(IsNear(W.transpose() * W, expected, 1e-14));
  EXPECT_EQ(ClassifyInformation<3>(information), InformationKind::kPositiveDefinite);
  EXPECT_NEAR(InformationEigenvalues<3>(information).min, InformationEigenvalues<3>(expected).min,
              1e-14);
  information(0, 1) = 2.5;  // beyond what two variances of 2 allow
  EXPECT_EQ(ClassifyInformation<3>(information), InformationKind::kIndefinite);
  EXPECT_FALSE(WhitenInformation<3>(information, &W));
}

// Of a unit diagonal: eigenvalues 1 + c and 1 - c.
Matrix2d Correlated(double c, double scale_x = 1, double scale_y = 1) {
  const Eigen::Vector2d scale(scale_x, scale_y);
  return scale.asDiagonal() * (Matrix2d() << 1, c, c, 1).finished() * scale.asDiagonal();
}

TEST(ClassifyInformationTest, ByTheSmallestEigenvalueAtAUnitDiagonal) {
  for (const double scale : {1e-7, 1., 1e8}) {
    const auto classify = [&](double smallest) {
      return ClassifyInformation<2>(Correlated(1 - smallest, 1, scale));
    };
    EXPECT_EQ(classify(1), InformationKind::kPositiveDefinite) << scale;
    EXPECT_EQ(classify(1.01e-9), InformationKind::kPositiveDefinite) << scale;
    EXPECT_EQ(classify(0.99e-9), InformationKind::kSemiDefinite) << scale;
    EXPECT_EQ(classify(0), InformationKind::kSemiDefinite) << scale;
    EXPECT_EQ(classify(-0.99e-9), InformationKind::kSemiDefinite) << scale;
    EXPECT_EQ(classify(-1.01e-9), InformationKind::kIndefinite) << scale;
    EXPECT_EQ(classify(-1e5), InformationKind::kIndefinite) << scale;
    EXPECT_EQ(classify(kNan), InformationKind::kNotFinite) << scale;
  }
  EXPECT_EQ(ClassifyInformation<3>(Matrix3d::Zero()), InformationKind::kSemiDefinite);
  EXPECT_EQ(ClassifyInformation<6>(-Matrix6d::Identity()), InformationKind::kIndefinite);
}

// Metres and radians share the matrix: what is small beside the largest eigenvalue may be large in
// its own row.
TEST(ClassifyInformationTest, SmallAndIndefiniteBesideALargeOne) {
  const auto expect_indefinite = [](const Matrix3d& information, const std::string& problem) {
    Matrix3d W;
    EXPECT_EQ(ClassifyInformation<3>(information), InformationKind::kIndefinite) << information;
    EXPECT_FALSE(WhitenInformation<3>(information, &W)) << information;
    EXPECT_EQ(InformationProblem<3>(information), problem);
  };
  const std::string what = "information is not positive semi-definite";
  Matrix3d information = Eigen::Vector3d(1, 1, 1e10).asDiagonal();
  information(0, 1) = information(1, 0) = 2;  // eigenvalues 3 and -1
  expect_indefinite(information, what + ", smallest eigenvalue -1");
  expect_indefinite(Eigen::Vector3d(1e10, 1, -1).asDiagonal(), what + ", smallest eigenvalue -1");
  information = Eigen::Vector3d(1, 0, 1e10).asDiagonal();
  information(0, 1) = information(1, 0) = 0.5;  // a zero in a row that is not
  expect_indefinite(information, what + ", smallest eigenvalue -0.207107");
  information = Eigen::Vector3d(1e-6, 1e-6, 1e10).asDiagonal();
  information(0, 1) = information(1, 0) = 1e-3;
  expect_indefinite(information, what + " beside its largest eigenvalue 1e+10");
}

TEST(ClassifyInformationTest, RoundingBesideTheLargestEntryIsZero) {
  Matrix3d information = Eigen::Vector3d(1, -1e-17, 1).asDiagonal();
  information(0, 1) = information(1, 0) = 1e-17;
  EXPECT_EQ(ClassifyInformation<3>(information), InformationKind::kSemiDefinite);
  Matrix3d W;
  ASSERT_TRUE(WhitenInformation<3>(information, &W));
  EXPECT_EQ(W.col(1).norm(), 0);
  const Matrix3d flat_information = Eigen::Vector3d(1, 0, 1).asDiagonal();
  EXPECT_TRUE(IsNear(W.transpose() * W, flat_information, 1e-15));
  // The square of a direction that is turned has such entries.
  std::mt19937 rng(5);
  for (int k = 0; k < 200; ++k) {
    const Matrix3d Q = Eigen::Quaterniond::UnitRandom().matrix();
    const Matrix3d flat = Q * Eigen::Vector3d(1e10, 1, 0).asDiagonal() * Q.transpose();
    EXPECT_NE(ClassifyInformation<3>(flat), InformationKind::kIndefinite) << flat;
  }
}

TEST(ClassifyInformationTest, AgreesWithWhitening) {
  std::mt19937 rng(6);
  std::uniform_real_distribution<double> uniform(-1, 1), exponent(-12, 12);
  for (int k = 0; k < 2000; ++k) {
    Matrix3d information;
    Eigen::Vector3d scale;
    for (int r = 0; r < 3; ++r) {
      scale(r) = std::pow(10, exponent(rng));
      for (int c = 0; c <= r; ++c) information(r, c) = information(c, r) = uniform(rng) + (r == c);
    }
    information = scale.asDiagonal() * information * scale.asDiagonal();
    Matrix3d W;
    EXPECT_EQ(WhitenInformation<3>(information, &W),
              ClassifyInformation<3>(information) != InformationKind::kIndefinite)
        << information;
  }
}

TEST(ClassifyInformationTest, ToleranceIsTheCallers) {
  const Matrix2d information = Correlated(1 + 1e-4);
  EXPECT_EQ(ClassifyInformation<2>(information, 1e-3), InformationKind::kSemiDefinite);
  EXPECT_EQ(ClassifyInformation<2>(information, 1e-5), InformationKind::kIndefinite);
}

TEST(InformationEigenvaluesTest, AreTheExtremes) {
  Matrix2d information;
  information << 1, 2, 2, 1;
  const EigenvalueRange range = InformationEigenvalues<2>(information);
  EXPECT_NEAR(range.min, -1, 1e-14);
  EXPECT_NEAR(range.max, 3, 1e-14);
  information(0, 1) = kNan;
  EXPECT_TRUE(std::isnan(InformationEigenvalues<2>(information).min));
}

TEST(ProjectInformationTest, RaisesEigenvaluesToTheFloor) {
  Matrix2d information;
  information << 1, 2, 2, 1;  // 3 along (1, 1), -1 along (1, -1)
  const Matrix2d projected = ProjectInformation<2>(information);
  EXPECT_TRUE(IsNear(projected, Matrix2d::Constant(1.5), 1e-8));
  EXPECT_EQ(projected, projected.transpose());
  EXPECT_NEAR(InformationEigenvalues<2>(projected).min, 3e-9, 1e-14);
  Matrix2d W;
  EXPECT_TRUE(WhitenInformation<2>(projected, &W));
}

TEST(ProjectInformationTest, KeepsWhatIsAboveTheFloor) {
  std::mt19937 rng(4);
  const Matrix6d information = RandomInformation<6>(&rng);
  EXPECT_TRUE(IsNear(ProjectInformation<6>(information), information, 1e-13));
  EXPECT_EQ(ProjectInformation<3>(-Matrix3d::Identity()), Matrix3d::Zero());
}

}  // namespace
}  // namespace ceres_costs
