// The pose graph examples of Ceres in shape (examples/slam/pose_graph_2d and _3d): their types, how
// they build the problem, and one word changed in how they solve it.
#include <cmath>
#include <map>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Geometry"
#include "ceres/ceres.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "hpgo/ceres/solve.h"

namespace {

template <typename T>
T NormalizeAngle(const T& angle) {
  const T two_pi(2.0 * M_PI);
  return angle - two_pi * ceres::floor((angle + T(M_PI)) / two_pi);
}

struct Pose2d {
  double x, y, yaw_radians;
};
struct Constraint2d {
  int id_begin, id_end;
  double x, y, yaw_radians;
  Eigen::Matrix3d information;
};

struct AngleManifold {
  template <typename T>
  bool Plus(const T* x, const T* delta, T* y) const {
    *y = NormalizeAngle(*x + *delta);
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* delta) const {
    *delta = NormalizeAngle(*y) - NormalizeAngle(*x);
    return true;
  }
  static ceres::Manifold* Create() { return new ceres::AutoDiffManifold<AngleManifold, 1, 1>; }
};

struct PoseGraph2dErrorTerm {
  template <typename T>
  bool operator()(const T* x_a, const T* y_a, const T* yaw_a, const T* x_b, const T* y_b,
                  const T* yaw_b, T* residuals) const {
    const T c = ceres::cos(*yaw_a), s = ceres::sin(*yaw_a);
    const T dx = *x_b - *x_a, dy = *y_b - *y_a;
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r(0) = c * dx + s * dy - T(constraint.x);
    r(1) = -s * dx + c * dy - T(constraint.y);
    r(2) = NormalizeAngle((*yaw_b - *yaw_a) - T(constraint.yaw_radians));
    r = sqrt_information.template cast<T>() * r;
    return true;
  }
  Constraint2d constraint;
  Eigen::Matrix3d sqrt_information;
};

void BuildOptimizationProblem(const std::vector<Constraint2d>& constraints,
                              std::map<int, Pose2d>* poses, ceres::Problem* problem) {
  ceres::Manifold* angle_manifold = AngleManifold::Create();
  for (const Constraint2d& constraint : constraints) {
    Pose2d& a = poses->at(constraint.id_begin);
    Pose2d& b = poses->at(constraint.id_end);
    auto* cost = new ceres::AutoDiffCostFunction<PoseGraph2dErrorTerm, 3, 1, 1, 1, 1, 1, 1>(
        new PoseGraph2dErrorTerm{constraint, constraint.information.llt().matrixL()});
    problem->AddResidualBlock(cost, nullptr, &a.x, &a.y, &a.yaw_radians, &b.x, &b.y,
                              &b.yaw_radians);
    problem->SetManifold(&a.yaw_radians, angle_manifold);
    problem->SetManifold(&b.yaw_radians, angle_manifold);
  }
  Pose2d& first = poses->begin()->second;
  problem->SetParameterBlockConstant(&first.x);
  problem->SetParameterBlockConstant(&first.y);
  problem->SetParameterBlockConstant(&first.yaw_radians);
}

bool SolveOptimizationProblem(ceres::Problem* problem, ceres::Solver::Summary* summary) {
  ceres::Solver::Options options;
  options.max_num_iterations = 100;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  hpgo::Solve(options, problem, summary);  // was: ceres::Solve
  return summary->IsSolutionUsable();
}

TEST(PoseGraphExamples, Planar) {
  std::map<int, Pose2d> poses;
  std::vector<Constraint2d> constraints;
  for (int k = 0; k < 8; ++k) {
    poses[k] = {0.4 * k, -0.2 * k, 0.3 * k};  // a square is wanted
    constraints.push_back(
        {k, (k + 1) % 8, 1, 0, k % 2 == 1 ? M_PI / 2 : 0, Eigen::Matrix3d::Identity()});
  }
  ceres::Problem problem;
  BuildOptimizationProblem(constraints, &poses, &problem);
  ceres::Solver::Summary summary;
  ASSERT_TRUE(SolveOptimizationProblem(&problem, &summary)) << summary.FullReport();
  EXPECT_THAT(summary.message, testing::StartsWith("hpgo: 7 poses (scalars x, y, yaw): "));
  EXPECT_LT(summary.final_cost, 1e-12);
  EXPECT_NEAR(poses[4].x, 2, 1e-6);
  EXPECT_NEAR(poses[4].y, 2, 1e-6);
  EXPECT_EQ(poses[0].x, 0);
}

struct Pose3d {
  Eigen::Vector3d p;
  Eigen::Quaterniond q;
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};
struct Constraint3d {
  int id_begin, id_end;
  Pose3d t_be;
  Eigen::Matrix<double, 6, 6> information;
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

struct PoseGraph3dErrorTerm {
  template <typename T>
  bool operator()(const T* p_a, const T* q_a, const T* p_b, const T* q_b, T* residuals) const {
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> pa(p_a), pb(p_b);
    const Eigen::Map<const Eigen::Quaternion<T>> qa(q_a), qb(q_b);
    const Eigen::Quaternion<T> q_ab = qa.conjugate() * qb;
    const Eigen::Matrix<T, 3, 1> p_ab = qa.conjugate() * Eigen::Matrix<T, 3, 1>(pb - pa);
    const Eigen::Quaternion<T> delta = t_ab.q.template cast<T>() * q_ab.conjugate();
    Eigen::Map<Eigen::Matrix<T, 6, 1>> r(residuals);
    r.template head<3>() = p_ab - t_ab.p.template cast<T>();
    r.template tail<3>() = T(2.0) * delta.vec();
    r.applyOnTheLeft(sqrt_information.template cast<T>());
    return true;
  }
  Pose3d t_ab;
  Eigen::Matrix<double, 6, 6> sqrt_information;
  EIGEN_MAKE_ALIGNED_OPERATOR_NEW
};

void BuildOptimizationProblem(const std::vector<Constraint3d>& constraints,
                              std::map<int, Pose3d>* poses, ceres::Problem* problem) {
  ceres::Manifold* quaternion_manifold = new ceres::EigenQuaternionManifold;
  for (const Constraint3d& constraint : constraints) {
    Pose3d& a = poses->at(constraint.id_begin);
    Pose3d& b = poses->at(constraint.id_end);
    auto* cost = new ceres::AutoDiffCostFunction<PoseGraph3dErrorTerm, 6, 3, 4, 3, 4>(
        new PoseGraph3dErrorTerm{constraint.t_be, constraint.information.llt().matrixL()});
    problem->AddResidualBlock(cost, nullptr, a.p.data(), a.q.coeffs().data(), b.p.data(),
                              b.q.coeffs().data());
    problem->SetManifold(a.q.coeffs().data(), quaternion_manifold);
    problem->SetManifold(b.q.coeffs().data(), quaternion_manifold);
  }
  Pose3d& first = poses->begin()->second;
  problem->SetParameterBlockConstant(first.p.data());
  problem->SetParameterBlockConstant(first.q.coeffs().data());
}

TEST(PoseGraphExamples, Spatial) {
  std::map<int, Pose3d> poses;
  std::vector<Constraint3d> constraints;
  for (int k = 0; k < 8; ++k) {
    poses[k].p = Eigen::Vector3d(0.4 * k, -0.2 * k, 0.1 * k);
    poses[k].q = Eigen::AngleAxisd(0.3 * k, Eigen::Vector3d(0.1, 0.2, 1).normalized());
    Constraint3d constraint;
    constraint.id_begin = k;
    constraint.id_end = (k + 1) % 8;
    constraint.t_be.p = Eigen::Vector3d(1, 0, 0);
    constraint.t_be.q = Eigen::AngleAxisd(k % 2 == 1 ? M_PI / 2 : 0, Eigen::Vector3d::UnitZ());
    constraint.information.setIdentity();
    constraints.push_back(constraint);
  }
  ceres::Problem problem;
  BuildOptimizationProblem(constraints, &poses, &problem);
  ceres::Solver::Summary summary;
  ASSERT_TRUE(SolveOptimizationProblem(&problem, &summary)) << summary.FullReport();
  EXPECT_THAT(summary.message, testing::StartsWith("hpgo: 7 poses (translation and quaternion): "));
  EXPECT_LT(summary.final_cost, 1e-9);
  EXPECT_NEAR((poses[4].p - Eigen::Vector3d(2, 2, 0)).norm(), 0, 1e-4);
  EXPECT_EQ(poses[0].p, Eigen::Vector3d(0, 0, 0));
}

}  // namespace
