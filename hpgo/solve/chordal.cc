#include "hpgo/solve/chordal.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/Eigenvalues"
#include "ceres_costs/relative_pose_error.h"
#include "hpgo/solve/chordal_system.h"
#include "hpgo/solve/initial_guess_rotation.h"

namespace hpgo {
namespace {

// Semi-definite measurements get this share of the mean weight in the directions they leave open,
// so that the systems are positive definite.
constexpr double kWeightFloor = 1e-9;

// P with tr(P) I - P = S, S the information of the rotation when the translation is free. Where S
// is too far from isotropic there is no such P that is positive semi-definite: the nearest one.
template <typename G>
typename G::RotationMatrix RotationWeight(const typename G::Matrix& information) {
  constexpr int d = G::kDim, r = G::kRotationDof;
  using Rotational = Eigen::Matrix<double, r, r>;
  const Eigen::SelfAdjointEigenSolver<typename G::RotationMatrix> translational(
      information.template topLeftCorner<d, d>());
  const Eigen::Matrix<double, d, r> coupling =
      translational.eigenvectors().transpose() * information.template topRightCorner<d, r>();
  Rotational S = information.template bottomRightCorner<r, r>();
  for (int k = 0; k < d; ++k) {
    const double value = translational.eigenvalues()(k);
    if (value > 1e-12 * translational.eigenvalues()(d - 1)) {
      S -= coupling.row(k).transpose() * coupling.row(k) / value;
    }
  }
  if constexpr (d == 2) {
    return 0.5 * std::max(S(0, 0), 0.0) * Eigen::Matrix2d::Identity();
  } else {
    const Eigen::SelfAdjointEigenSolver<Rotational> spectrum(
        0.5 * S.trace() * Rotational::Identity() - S);
    return spectrum.eigenvectors() * spectrum.eigenvalues().cwiseMax(0.0).asDiagonal() *
           spectrum.eigenvectors().transpose();
  }
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

  Result<std::vector<G>> Solve() {
    if (unknowns_ == 0) return poses_;
    std::vector<std::pair<int, int>> pairs;
    pairs.reserve(graph_.edges().size());
    for (const GraphEdge<G>& edge : graph_.edges()) {
      const int i = unknown_[edge.i], j = unknown_[edge.j];
      if (i != kKnown && j != kKnown) pairs.emplace_back(i, j);
    }
    BlockSystem<d> system(unknowns_, pairs);
    if (!SolveRotations(&system)) {
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
  using Block = typename G::RotationMatrix;
  using Vector = typename G::Vector;

  // The transposed rotations Y: each edge asks for Y_j = R_ij' Y_i, weighted by P.
  bool SolveRotations(BlockSystem<d>* system) {
    std::vector<Block> weights;
    double total = 0;
    const auto add = [&](const typename G::Matrix& information) {
      weights.push_back(RotationWeight<G>(information));
      total += weights.back().trace();
    };
    for (const GraphEdge<G>& edge : graph_.edges()) add(edge.information);
    for (const GraphPrior<G>& prior : graph_.priors()) add(prior.information);
    const double floor = kWeightFloor * total / weights.size() / d + kTiny;

    system->Reset(d);
    std::size_t k = 0;
    for (const GraphEdge<G>& edge : graph_.edges()) {
      const Block P = weights[k++] + floor * Block::Identity();
      const Block R = edge.measurement.matrix();
      const Block RP = R * P;
      AddRelative<d>(edge.i, edge.j, RP * R.transpose(), -RP, P, Block::Zero(), Block::Zero(),
                     poses_[edge.i].matrix().transpose(), poses_[edge.j].matrix().transpose(),
                     system);
    }
    for (const GraphPrior<G>& prior : graph_.priors()) {
      const Block RP = prior.offset.matrix() * weights[k++];
      const int u = unknown_[prior.node];
      if (u == kKnown) continue;
      system->AddDiagonal(u, RP * prior.offset.matrix().transpose());
      system->AddRight(u, RP * prior.measurement.matrix().transpose());
    }
    if (!system->Solve()) return false;
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (unknown_[i] == kKnown) continue;
      const Block relaxed = system->Solution(unknown_[i]).transpose();
      SetRotation(NearestRotation<d>(relaxed, poses_[i].matrix()), &poses_[i]);
    }
    return true;
  }

  // With e_t = B (t_j - t_i) - c and e_r known, the objective's part in t is
  // e_t' W e_t + 2 e_t' a, where a = Omega_tr e_r.
  bool SolveTranslations(BlockSystem<d>* system) {
    double total = 0;
    for (const GraphEdge<G>& edge : graph_.edges()) {
      total += edge.information.template topLeftCorner<d, d>().trace();
    }
    const double edges = std::max<double>(1, graph_.edges().size());
    const double floor = kWeightFloor * total / edges / d + kTiny;

    system->Reset(1);
    for (const GraphEdge<G>& edge : graph_.edges()) {
      const Block Rt = edge.measurement.matrix().transpose();
      const Block B = Rt * poses_[edge.i].matrix().transpose();
      const Vector c = Rt * edge.measurement.translation();
      const Block W = edge.information.template topLeftCorner<d, d>() + floor * Block::Identity();
      const G D = edge.measurement.Between(poses_[edge.i].Between(poses_[edge.j]));
      const Vector right = B.transpose() * (W * c - RotationPull(edge.information, D));
      const Block A = B.transpose() * W * B;
      AddRelative<1>(edge.i, edge.j, A, -A, A, -right, right, poses_[edge.i].translation(),
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

  // Adds the normal equations [A_ii A_ij; A_ij' A_jj] [x_i; x_j] = [b_i; b_j], with the known
  // unknowns on the right side.
  template <int columns>
  void AddRelative(int i, int j, const Block& A_ii, const Block& A_ij, const Block& A_jj,
                   const Eigen::Matrix<double, d, columns>& b_i,
                   const Eigen::Matrix<double, d, columns>& b_j,
                   const Eigen::Matrix<double, d, columns>& x_i,
                   const Eigen::Matrix<double, d, columns>& x_j, BlockSystem<d>* system) {
    const int u = unknown_[i], v = unknown_[j];
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
    if (u != kKnown && v != kKnown) system->AddOffDiagonal(u, v, A_ij);
  }

  // Keeps a graph without any information solvable.
  static constexpr double kTiny = 1e-100;

  const PoseGraph<G>& graph_;
  std::vector<G> poses_;
  std::vector<int> unknown_;  // by node: the number of its unknown, or kKnown
  int unknowns_ = 0;
};

}  // namespace

template <typename G>
Result<std::vector<G>> ChordalPoses(const PoseGraph<G>& graph,
                                    const std::vector<Anchor<G>>& anchors,
                                    const std::vector<G>& start) {
  return Chordal<G>(graph, anchors, start).Solve();
}

template Result<std::vector<SE2>> ChordalPoses(const PoseGraph<SE2>&,
                                               const std::vector<Anchor<SE2>>&,
                                               const std::vector<SE2>&);
template Result<std::vector<SE3>> ChordalPoses(const PoseGraph<SE3>&,
                                               const std::vector<Anchor<SE3>>&,
                                               const std::vector<SE3>&);

}  // namespace hpgo
