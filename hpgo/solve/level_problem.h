// A level of the hierarchy as a ceres::Problem: to evaluate, to ask ceres::Covariance, to debug.
#pragma once

#include <memory>
#include <unordered_map>
#include <vector>

#include "hpgo/hierarchy/hierarchy.h"
#include "hpgo/solve/ceres_poses.h"

namespace hpgo {

// A snapshot. A block for every node of the level at T_world_node, in the storage order of G on
// PoseManifold, fixed ones constant, and the first where nothing else holds the level; a residual
// for every edge: on level 0 the edge's own cost or the Mahalanobis distance of a condensed chain,
// above it that of the Galerkin or condensed measurement, e' Omega e, merged at the current
// estimate. Ceres' cost is half the sum of these. Custom costs and losses are those of the
// optimizer: use the snapshot before their edges are removed. Solving it moves the snapshot alone.
template <typename G>
class CeresLevel {
 public:
  struct Node {
    Index index = 0;  // on the level: Optimizer::Group::id of the poses below it
    double* block = nullptr;
  };

  // kInvalidArgument where there is no such level.
  static Result<std::shared_ptr<CeresLevel>> Make(int level, Hierarchy<G>* hierarchy);

  int level() const { return level_; }
  ceres::Problem& problem() { return *problem_; }
  const std::vector<Node>& nodes() const { return nodes_; }
  // Null where the level has no such node.
  double* BlockOf(Index index) const;
  // Its edges as residual blocks have the order of the problem's.
  const std::vector<Index>& edges() const { return edges_; }

 private:
  explicit CeresLevel(int level) : level_(level) {}

  const int level_;
  CeresPoses<G> poses_{ceres_costs::JacobianKind::kAmbient};
  std::unique_ptr<ceres::Problem> problem_;
  std::vector<Node> nodes_;
  std::vector<Index> edges_;
  std::unordered_map<Index, double*> block_of_;
};

extern template class CeresLevel<ceres_costs::SE2>;
extern template class CeresLevel<ceres_costs::SE3>;
extern template class CeresLevel<ceres_costs::YawPose>;

}  // namespace hpgo
