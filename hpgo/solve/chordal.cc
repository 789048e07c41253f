#include "hpgo/solve/chordal.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ceres_costs/relative_pose_error.h"
#include "ceres_costs/symmetric_eigen.h"
#include "hpgo/solve/chordal_system.h"
#include "hpgo/solve/initial_guess_rotation.h"

namespace hpgo {
namespace {

// Semi-definite measurements get this share of the mean weight in the directions they leave open,
// so that the systems are positive definite.
constexpr double kWeightFloor = 1e-9;

// Half the mean information of the rotation's coordinates when the translation is free: the Schur
// complement of the translation. One number an edge: a matrix that reproduces each direction's
// information would often be singular, which costs far more than it brings.
template <typename G>
double RotationWeight(const typename G::Matrix& information) {
  constexpr int d = G::kDim, r = G::kRotationDof;
  const auto translational = ceres_costs::EigenOf<d>(information.template topLeftCorner<d, d>());
  const Eigen::Matrix<double, d, r> coupling =
      translational.vectors.transpose() * information.template topRightCorner<d, r>();
  double trace = information.template bottomRightCorner<r, r>().trace();
  for (int k = 0; k < d; ++k) {
    const double value = translational.values(k);
    if (value > 1e-12 * translational.values(d - 1)) {
      trace -= coupling.row(k).squaredNorm() / value;
    }
  }
  return 0.5 * std::max(trace, 0.0) / r;
}

template <typename G>
class Chordal {
 public:
  Chordal(const PoseGraph<G>& graph, const std::vector<Anchor<G>>& anchors,
          const std::vector<G>& start)
      : graph_(graph), poses_(start), unknown_(start.size(), 0) {
    for (const Anchor<G>& anchor : anchors) {
      poses_[anchor.node] = anchor.pose;
      unknown_[anchor.node] = kKnown;
    }
    for (int& u : unknown_) {
      if (u != kKnown) u = unknowns_++;
    }
  }

  // With `rotations` false those of the start stay.
  Result<std::vector<G>> Solve(bool rotations) {
    if (unknowns_ == 0) return poses_;
    std::vector<std::pair<int, int>> pairs;
    pairs.reserve(graph_.edges().size());
    for (const GraphEdge<G>& edge : graph_.edges()) {
      const int i = unknown_[edge.i], j = unknown_[edge.j];
      const bool both = i != kKnown && j != kKnown;
      pair_of_.push_back(both ? static_cast<int>(pairs.size()) : kNone);
      if (both) pairs.emplace_back(i, j);
    }
    ChordalSystem<d> system(unknowns_, pairs);
    if (rotations && !SolveRotations(&system)) {
      return Status(StatusCode::kNoSolution, "chordal rotations: the system is singular");
    }
    if (!SolveTranslations(&system)) {
      return Status(StatusCode::kNoSolution, "chordal translations: the system is singular");
    }
    return std::move(poses_);
  }

 private:
  static constexpr int d = G::kDim;
  static constexpr int r = G::kRotationDof;
  static constexpr int kKnown = -1;
  static constexpr int kNone = -1;
  using Block = typename G::RotationMatrix;
  using Vector = typename G::Vector;

  // The transposed rotations Y: each edge asks for Y_j = R_ij' Y_i, weighted by p.
  bool SolveRotations(ChordalSystem<d>* system) {
    std::vector<double> weights;
    double total = 0;
    const auto add = [&](const typename G::Matrix& information) {
      weights.push_back(RotationWeight<G>(information));
      total += weights.back();
    };
    for (const GraphEdge<G>& edge : graph_.edges()) add(edge.information);
    for (const GraphPrior<G>& prior : graph_.priors()) add(prior.information);
    const double floor = kWeightFloor * total / static_cast<double>(weights.size()) + kTiny;

    system->Reset(d);
    const std::size_t edges = graph_.edges().size();
    for (std::size_t k = 0; k < edges; ++k) {
      const GraphEdge<G>& edge = graph_.edges()[k];
      const double p = weights[k] + floor;
      const Block P = p * Block::Identity();
      AddRelative<d>(k, P, -p * edge.measurement.matrix(), P, Block::Zero(), Block::Zero(),
                     poses_[edge.i].matrix().transpose(), poses_[edge.j].matrix().transpose(),
                     system);
    }
    for (std::size_t k = 0; k < graph_.priors().size(); ++k) {
      const GraphPrior<G>& prior = graph_.priors()[k];
      const double p = weights[edges + k];
      const int u = unknown_[prior.node];
      if (u == kKnown) continue;
      system->AddDiagonal(u, p * Block::Identity());
      system->AddRight(u, p * prior.offset.matrix() * prior.measurement.matrix().transpose());
    }
    if (!system->Solve()) return false;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (unknown_[i] == kKnown) continue;
      const Block relaxed = system->Solution(unknown_[i]).transpose();
      SetNearestRotation(relaxed, poses_[i].matrix(), &poses_[i]);
    }
    return true;
  }

  // With e_t = B (t_j - t_i) - c and e_r known, the objective's part in t is
  // e_t' W e_t + 2 e_t' a, where a = Omega_tr e_r.
  bool SolveTranslations(ChordalSystem<d>* system) {
    double total = 0;
    for (const GraphEdge<G>& edge : graph_.edges()) {
      total += edge.information.template topLeftCorner<d, d>().trace();
    }
    const double floor =
        kWeightFloor * total / static_cast<double>(graph_.edges().size()) / d + kTiny;

    system->Reset(1);
    for (std::size_t k = 0; k < graph_.edges().size(); ++k) {
      const GraphEdge<G>& edge = graph_.edges()[k];
      const Block Rt = edge.measurement.matrix().transpose();
      const Block B = Rt * poses_[edge.i].matrix().transpose();
      const Vector c = Rt * edge.measurement.translation();
      const Block W = edge.information.template topLeftCorner<d, d>() + floor * Block::Identity();
      const G D = edge.measurement.Between(poses_[edge.i].Between(poses_[edge.j]));
      const Vector right = B.transpose() * (W * c - RotationPull(edge.information, D));
      const Block A = B.transpose() * W * B;
      AddRelative<1>(k, A, -A, A, -right, right, poses_[edge.i].translation(),
                     poses_[edge.j].translation(), system);
    }
    for (const GraphPrior<G>& prior : graph_.priors()) {
      const int u = unknown_[prior.node];
      if (u == kKnown) continue;
      const G& X = poses_[prior.node];
      const Block B = prior.measurement.matrix().transpose();
      const Vector c =
          B * (prior.measurement.translation() - X.matrix() * Vector(prior.offset.translation()));
      const Block W = prior.information.template topLeftCorner<d, d>();
      const G D = prior.measurement.Between(X * prior.offset);
      system->AddDiagonal(u, B.transpose() * W * B);
      system->AddRight(u, B.transpose() * (W * c - RotationPull(prior.information, D)));
    }
    if (!system->Solve()) return false;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (unknown_[i] != kKnown) poses_[i].translation() = system->Solution(unknown_[i]);
    }
    return true;
  }

  // Omega_tr e_r: the pull of the known rotational error D on the translation.
  static Vector RotationPull(const typename G::Matrix& information, const G& D) {
    return information.template topRightCorner<d, r>() *
           DeviationError(ceres_costs::ErrorConvention::kG2o, D).template tail<r>();
  }

  // Adds the normal equations [A_ii A_ij; A_ij' A_jj] [x_i; x_j] = [b_i; b_j] of an edge, with what
  // is known of x on the right side.
  template <int columns>
  void AddRelative(std::size_t edge, const Block& A_ii, const Block& A_ij, const Block& A_jj,
                   const Eigen::Matrix<double, d, columns>& b_i,
                   const Eigen::Matrix<double, d, columns>& b_j,
                   const Eigen::Matrix<double, d, columns>& x_i,
                   const Eigen::Matrix<double, d, columns>& x_j, ChordalSystem<d>* system) {
    const int u = unknown_[graph_.edges()[edge].i], v = unknown_[graph_.edges()[edge].j];
    if (u != kKnown) {
      system->AddDiagonal(u, A_ii);
      system->AddRight(u, b_i);
      if (v == kKnown) system->AddRight(u, -A_ij * x_j);
    }
    if (v != kKnown) {
      system->AddDiagonal(v, A_jj);
      system->AddRight(v, b_j);
      if (u == kKnown) system->AddRight(v, -A_ij.transpose() * x_i);
    }
    if (pair_of_[edge] != kNone) system->AddOffDiagonal(pair_of_[edge], A_ij);
  }

  // Keeps a graph without any information solvable.
  static constexpr double kTiny = 1e-100;

  const PoseGraph<G>& graph_;
  std::vector<G> poses_;
  std::vector<int> unknown_;  // by node: the number of its unknown, or kKnown
  std::vector<int> pair_of_;  // by edge: the number of its pair of unknowns, or kNone
  int unknowns_ = 0;
};

}  // namespace

template <typename G>
Result<std::vector<G>> ChordalPoses(const PoseGraph<G>& graph,
                                    const std::vector<Anchor<G>>& anchors,
                                    const std::vector<G>& start) {
  return Chordal<G>(graph, anchors, start).Solve(true);
}

template <typename G>
Result<std::vector<G>> ChordalTranslations(const PoseGraph<G>& graph,
                                           const std::vector<Anchor<G>>& anchors,
                                           const std::vector<G>& poses) {
  return Chordal<G>(graph, anchors, poses).Solve(false);
}

template Result<std::vector<SE2>> ChordalPoses(const PoseGraph<SE2>&,
                                               const std::vector<Anchor<SE2>>&,
                                               const std::vector<SE2>&);
template Result<std::vector<SE3>> ChordalPoses(const PoseGraph<SE3>&,
                                               const std::vector<Anchor<SE3>>&,
                                               const std::vector<SE3>&);
template Result<std::vector<YawPose>> ChordalPoses(const PoseGraph<YawPose>&,
                                                   const std::vector<Anchor<YawPose>>&,
                                                   const std::vector<YawPose>&);
template Result<std::vector<SE2>> ChordalTranslations(const PoseGraph<SE2>&,
                                                      const std::vector<Anchor<SE2>>&,
                                                      const std::vector<SE2>&);
template Result<std::vector<SE3>> ChordalTranslations(const PoseGraph<SE3>&,
                                                      const std::vector<Anchor<SE3>>&,
                                                      const std::vector<SE3>&);
template Result<std::vector<YawPose>> ChordalTranslations(const PoseGraph<YawPose>&,
                                                          const std::vector<Anchor<YawPose>>&,
                                                          const std::vector<YawPose>&);

}  // namespace hpgo
