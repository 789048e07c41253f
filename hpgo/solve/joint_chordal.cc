#include "hpgo/solve/joint_chordal.h"

#include <algorithm>
#include <utility>

#include "Eigen/Core"
#include "hpgo/graph/components.h"
#include "hpgo/solve/chordal.h"
#include "hpgo/solve/chordal_system.h"
#include "hpgo/solve/initial_guess_rotation.h"

namespace hpgo {
namespace {

// What a measurement leaves open gets this share of the mean weight.
constexpr double kWeightFloor = 1e-9;
// Keeps a graph without any information solvable.
constexpr double kTiny = 1e-100;

// The unknown of a node is the (d + 1) x d matrix of R' above t'.
template <typename G>
class JointChordal {
 public:
  JointChordal(const PoseGraph<G>& graph, const std::vector<Anchor<G>>& anchors,
               const std::vector<G>& start, const JointChordalOptions& options)
      : graph_(graph),
        anchors_(anchors),
        options_(options),
        components_(FindComponents(graph)),
        firm_(components_.count, true),
        poses_(start),
        unknown_(start.size(), 0) {
    for (std::size_t k = 0; k < anchors.size(); ++k) {
      const Anchor<G>& anchor = anchors[k];
      poses_[anchor.node] = anchor.pose;
      firm_[components_.of_node[anchor.node]] = anchor.firm;
      const bool elsewhere = !anchor.firm && k < options.roots.size();
      unknown_[elsewhere ? options.roots[k] : anchor.node] = kKnown;
    }
    for (int& u : unknown_) {
      if (u != kKnown) u = unknowns_++;
    }
  }

  Result<std::vector<G>> Solve() {
    if (unknowns_ > 0) {
      if (!SolveRotations()) {
        return Status(StatusCode::kNoSolution, "joint chordal: the system is singular");
      }
      TurnToAnchors();
    }
    return ChordalTranslations(graph_, anchors_, poses_);
  }

 private:
  static constexpr int d = G::kDim;
  static constexpr int r = G::kRotationDof;
  static constexpr int kKnown = -1;
  using Block = Eigen::Matrix<double, d + 1, d + 1>;
  using Value = Eigen::Matrix<double, d + 1, d>;
  using Rotation = typename G::RotationMatrix;

  // p of the rotations and w of the translations. With three angles the rotational error of g2o is
  // half the angle.
  struct Weights {
    double rotation = 0, translation = 0;
  };
  static Weights WeightsOf(const typename G::Matrix& information) {
    constexpr double kPerAngle = r == 3 ? 0.25 : 1;
    return {0.5 * kPerAngle * information.template bottomRightCorner<r, r>().trace() / r,
            information.template topLeftCorner<d, d>().trace() / d};
  }

  static Value Stack(const G& pose) {
    Value value;
    value.template topRows<d>() = pose.matrix().transpose();
    value.row(d) = pose.translation().transpose();
    return value;
  }
  // That by which the unknown of X is multiplied to become that of X * Z.
  static Block Composition(const G& Z) {
    Block block = Block::Identity();
    block.template topLeftCorner<d, d>() = Z.matrix().transpose();
    block.template block<1, d>(d, 0) = Z.translation().transpose();
    return block;
  }

  bool SolveRotations() {
    std::vector<std::pair<int, int>> pairs;
    std::vector<int> pair_of;
    Weights mean;
    for (const GraphEdge<G>& edge : graph_.edges()) {
      const int i = unknown_[edge.i], j = unknown_[edge.j];
      const bool both = i != kKnown && j != kKnown;
      pair_of.push_back(both ? static_cast<int>(pairs.size()) : kKnown);
      if (both) pairs.emplace_back(i, j);
      const Weights weights = WeightsOf(edge.information);
      mean.rotation += weights.rotation / static_cast<double>(graph_.edges().size());
      mean.translation += weights.translation / static_cast<double>(graph_.edges().size());
    }
    ChordalSystem<d + 1> system(unknowns_, pairs);
    system.Reset(d);
    const auto diagonal = [&](const Weights& weights, double floor) {
      Eigen::Matrix<double, d + 1, 1> values;
      values.setConstant(weights.rotation + floor * mean.rotation + kTiny);
      values(d) = weights.translation + floor * mean.translation + kTiny;
      return values;
    };
    for (std::size_t k = 0; k < graph_.edges().size(); ++k) {
      const GraphEdge<G>& edge = graph_.edges()[k];
      const double factor = options_.weights.empty() ? 1 : options_.weights[k];
      const Block W =
          Block((factor * diagonal(WeightsOf(edge.information), kWeightFloor)).asDiagonal());
      const Block C = Composition(edge.measurement.Normalized());
      const int i = unknown_[edge.i], j = unknown_[edge.j];
      if (i != kKnown) {
        system.AddDiagonal(i, C.transpose() * W * C);
        if (j == kKnown) system.AddRight(i, C.transpose() * W * Stack(poses_[edge.j]));
      }
      if (j != kKnown) {
        system.AddDiagonal(j, W);
        if (i == kKnown) system.AddRight(j, W * C * Stack(poses_[edge.i]));
      }
      if (pair_of[k] != kKnown) system.AddOffDiagonal(pair_of[k], -C.transpose() * W);
    }
    for (const GraphPrior<G>& prior : graph_.priors()) {
      const int u = unknown_[prior.node];
      // The priors of a loose component know another frame than its anchor.
      if (u == kKnown || !firm_[components_.of_node[prior.node]]) continue;
      const Block W = Block(diagonal(WeightsOf(prior.information), 0).asDiagonal());
      const Block C = Composition(prior.offset.Normalized());
      system.AddDiagonal(u, C.transpose() * W * C);
      system.AddRight(u, C.transpose() * W * Stack(prior.measurement.Normalized()));
    }
    if (!system.Solve()) return false;
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      if (unknown_[k] == kKnown) continue;
      const Rotation relaxed = system.Solution(unknown_[k]).template topRows<d>().transpose();
      SetNearestRotation(relaxed, poses_[k].matrix(), &poses_[k]);
    }
    return true;
  }

  // Turns each component of which another node was held, so that its anchor looks as it should.
  void TurnToAnchors() {
    if (options_.roots.empty()) return;
    std::vector<Rotation> turn(components_.count, Rotation::Identity());
    for (const Anchor<G>& anchor : anchors_) {
      if (anchor.firm) continue;
      turn[components_.of_node[anchor.node]] =
          anchor.pose.matrix() * poses_[anchor.node].matrix().transpose();
    }
    for (std::size_t k = 0; k < poses_.size(); ++k) {
      const Rotation turned = turn[components_.of_node[k]] * poses_[k].matrix();
      SetNearestRotation(turned, turned, &poses_[k]);
    }
  }

  const PoseGraph<G>& graph_;
  const std::vector<Anchor<G>>& anchors_;
  const JointChordalOptions& options_;
  const Components components_;
  std::vector<bool> firm_;  // by component: its anchors are
  std::vector<G> poses_;
  std::vector<int> unknown_;  // by node: the number of its unknown, or kKnown
  int unknowns_ = 0;
};

}  // namespace

template <typename G>
Result<std::vector<G>> JointChordalPoses(const PoseGraph<G>& graph,
                                         const std::vector<Anchor<G>>& anchors,
                                         const std::vector<G>& start,
                                         const JointChordalOptions& options) {
  return JointChordal<G>(graph, anchors, start, options).Solve();
}

template Result<std::vector<SE2>> JointChordalPoses(const PoseGraph<SE2>&,
                                                    const std::vector<Anchor<SE2>>&,
                                                    const std::vector<SE2>&,
                                                    const JointChordalOptions&);
template Result<std::vector<SE3>> JointChordalPoses(const PoseGraph<SE3>&,
                                                    const std::vector<Anchor<SE3>>&,
                                                    const std::vector<SE3>&,
                                                    const JointChordalOptions&);
template Result<std::vector<YawPose>> JointChordalPoses(const PoseGraph<YawPose>&,
                                                        const std::vector<Anchor<YawPose>>&,
                                                        const std::vector<YawPose>&,
                                                        const JointChordalOptions&);

}  // namespace hpgo
