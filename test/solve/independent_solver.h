// A second opinion on the optimum: Gauss-Newton written from the definition of chi2 alone, on
// rotation matrices, with numeric Jacobians and Eigen. It shares no code with what it checks beyond
// the graph's containers.
#pragma once

#include <cmath>
#include <vector>

#include "Eigen/Geometry"
#include "Eigen/SparseCholesky"
#include "hpgo/graph/pose_graph.h"

namespace hpgo {

template <typename G>
class IndependentSolver {
 public:
  static constexpr int d = G::kDim, dof = G::kDof, r = G::kRotationDof;
  using Vector = Eigen::Matrix<double, d, 1>;
  using Rotation = Eigen::Matrix<double, d, d>;
  using Error = Eigen::Matrix<double, dof, 1>;
  struct Pose {
    Vector t;
    Rotation R;
  };

  // At the poses of the graph. The node `held` keeps its pose; priors are not supported.
  IndependentSolver(const PoseGraph<G>& graph, int held) : graph_(graph), held_(held) {
    for (const GraphNode<G>& node : graph.nodes()) poses_.push_back(FromGroup(node.pose));
    for (const GraphEdge<G>& edge : graph.edges()) {
      measurements_.push_back(FromGroup(edge.measurement));
    }
  }

  double Chi2() const {
    double sum = 0;
    for (std::size_t k = 0; k < measurements_.size(); ++k) {
      const Error e = EdgeError(k, poses_[graph_.edges()[k].i], poses_[graph_.edges()[k].j]);
      sum += e.dot(graph_.edges()[k].information * e);
    }
    return sum;
  }

  struct Step {
    bool positive_definite = false;  // the Gauss-Newton Hessian
    double predicted_decrease = 0;   // of chi2, by the quadratic model
  };

  // One full Gauss-Newton step; the poses move if `apply`.
  Step Iterate(bool apply) {
    const int size = dof * static_cast<int>(poses_.size());
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
    for (std::size_t k = 0; k < measurements_.size(); ++k) {
      const GraphEdge<G>& edge = graph_.edges()[k];
      Eigen::Matrix<double, dof, 2 * dof> J;
      for (int c = 0; c < 2 * dof; ++c) J.col(c) = Derivative(k, c);
      const Error e = EdgeError(k, poses_[edge.i], poses_[edge.j]);
      const Eigen::Matrix<double, 2 * dof, 2 * dof> H = J.transpose() * edge.information * J;
      const Eigen::Matrix<double, 2 * dof, 1> g = J.transpose() * edge.information * e;
      const int base[2] = {dof * edge.i, dof * edge.j};
      for (int a = 0; a < 2 * dof; ++a) {
        const int row = base[a / dof] + a % dof;
        gradient(row) += g(a);
        for (int b = 0; b < 2 * dof; ++b) {
          const int column = base[b / dof] + b % dof;
          if (row / dof != held_ && column / dof != held_ && row >= column) {
            entries.emplace_back(row, column, H(a, b));
          }
        }
      }
    }
    for (int c = 0; c < dof; ++c) {
      entries.emplace_back(dof * held_ + c, dof * held_ + c, 1.0);
      gradient(dof * held_ + c) = 0;
    }
    Eigen::SparseMatrix<double> H(size, size);
    H.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factorization(H);
    const Eigen::VectorXd step = factorization.solve(-gradient);
    if (apply) {
      for (std::size_t i = 0; i < poses_.size(); ++i) {
        poses_[i] = Moved(poses_[i], step.template segment<dof>(dof * i));
      }
    }
    Step result;
    result.positive_definite =
        factorization.info() == Eigen::Success && factorization.vectorD().minCoeff() > 0;
    result.predicted_decrease = -gradient.dot(step);
    return result;
  }

  // Gauss-Newton until a step promises less than 1e-12 of chi2; the chi2 reached.
  double Solve(int max_iterations = 50) {
    for (int k = 0; k < max_iterations; ++k) {
      if (!(Iterate(true).predicted_decrease > 1e-12 * Chi2())) break;
    }
    return Chi2();
  }

 private:
  static Pose FromGroup(const SE2& X) {
    return {Vector(X.translation()),
            Eigen::Rotation2Dd(X.data()[2]).toRotationMatrix().template topLeftCorner<d, d>()};
  }
  static Pose FromGroup(const SE3& X) {
    const double* q = X.data() + 3;
    return {Vector(X.translation()),
            Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix()};
  }
  static Pose FromGroup(const YawPose& X) {
    return {Vector(X.translation()), Rotate(Eigen::Matrix<double, 1, 1>(X.data()[3]))};
  }

  static Rotation Rotate(const Eigen::Matrix<double, 1, 1>& w) {
    Rotation R = Rotation::Identity();
    R.template topLeftCorner<2, 2>() = Eigen::Rotation2Dd(w(0)).toRotationMatrix();
    return R;
  }
  static Eigen::Matrix3d Rotate(const Eigen::Vector3d& w) {
    const double angle = w.norm();
    if (angle == 0) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  }
  // Translation in the world, rotation about the world's axes: not hpgo's own perturbation.
  static Pose Moved(const Pose& X, const Error& step) {
    const Eigen::Matrix<double, r, 1> w = step.template tail<r>();
    return {X.t + step.template head<d>(), Rotate(w) * X.R};
  }

  // The angle, or the vector part of the quaternion with w >= 0.
  static Eigen::Matrix<double, r, 1> RotationError(const Rotation& D) {
    if constexpr (r == 1) {
      return Eigen::Matrix<double, 1, 1>(std::atan2(D(1, 0), D(0, 0)));
    } else {
      const Eigen::AngleAxisd turn(D);  // of an angle in [0, pi]
      return std::sin(0.5 * turn.angle()) * turn.axis();
    }
  }

  Error EdgeError(std::size_t k, const Pose& X_i, const Pose& X_j) const {
    const Pose& Z = measurements_[k];
    Error e;
    e << Z.R.transpose() * (X_i.R.transpose() * (X_j.t - X_i.t) - Z.t),
        RotationError(Rotation(Z.R.transpose() * X_i.R.transpose() * X_j.R));
    return e;
  }

  // By the c-th coordinate of (X_i, X_j), central differences.
  Error Derivative(std::size_t k, int c) const {
    constexpr double kStep = 1e-6;
    const Pose &X_i = poses_[graph_.edges()[k].i], &X_j = poses_[graph_.edges()[k].j];
    Error step = Error::Zero();
    step(c % dof) = kStep;
    if (c < dof) {
      return (EdgeError(k, Moved(X_i, step), X_j) - EdgeError(k, Moved(X_i, -step), X_j)) /
             (2 * kStep);
    }
    return (EdgeError(k, X_i, Moved(X_j, step)) - EdgeError(k, X_i, Moved(X_j, -step))) /
           (2 * kStep);
  }

  const PoseGraph<G>& graph_;
  const int held_;
  std::vector<Pose> poses_, measurements_;
};

}  // namespace hpgo
