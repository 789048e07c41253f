#include "hpgo/ceres/kept_problem.h"

#include <algorithm>
#include <utility>

#include "hpgo/ceres/fingerprint.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

Status Refuse(const std::string& reason) { return Status(StatusCode::kInvalidArgument, reason); }

}  // namespace

template <typename G>
KeptProblemOf<G>::KeptProblemOf(ceres::Problem* problem, const OptimizerOptions& options,
                                const PoseLayout& layout)
    : problem_(*problem), codec_(layout), optimizer_(options) {}

template <typename G>
typename KeptProblemOf<G>::Residual KeptProblemOf<G>::Read(ceres::ResidualBlockId id) const {
  Residual residual;
  residual.cost = problem_.GetCostFunctionForResidualBlock(id);
  residual.loss = problem_.GetLossFunctionForResidualBlock(id);
  problem_.GetParameterBlocksForResidualBlock(id, &residual.blocks);
  residual.fingerprint = Fingerprint(*residual.cost, residual.loss);
  return residual;
}

template <typename G>
Status KeptProblemOf<G>::Add(ceres::ResidualBlockId id) {
  Residual residual = Read(id);
  residual.seen = looks_;
  const Status status = Link(id, &residual);
  if (status.ok()) residuals_[id] = std::move(residual);
  return status;
}

template <typename G>
Status KeptProblemOf<G>::Remove(ceres::ResidualBlockId id) {
  const auto it = residuals_.find(id);
  if (it == residuals_.end()) return Status::Ok();
  const Residual residual = std::move(it->second);
  residuals_.erase(it);
  Unlink(residual);
  for (const NodeId node : residual.nodes) {
    if (--nodes_.at(node).residuals > 0) continue;
    for (const double* block : nodes_.at(node).blocks) places_.erase(block);
    nodes_.erase(node);
    const Status status = optimizer_.RemoveNode(node).status();
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

template <typename G>
void KeptProblemOf<G>::Unlink(const Residual& residual) {
  // The cost itself may be gone: nothing is evaluated.
  if (residual.edge != EdgeId()) (void)optimizer_.RemoveEdge(residual.edge);
}

// Finds which poses it is over, makes nodes of new ones, and counts it among theirs.
template <typename G>
Status KeptProblemOf<G>::Link(ceres::ResidualBlockId id, Residual* residual) {
  Status status = FindNodes(id, residual);
  if (!status.ok()) return status;
  for (const NodeId node : residual->nodes) ++nodes_.at(node).residuals;
  std::vector<NodeId> moving;
  for (const NodeId node : residual->nodes) {
    if (!nodes_.at(node).fixed) moving.push_back(node);
  }
  if (moving.empty()) return Status::Ok();
  if (moving.size() > 2) {
    return Refuse(NameOf(id) + " spans " + std::to_string(moving.size()) + " poses");
  }
  // With a pose that is held it may be a relative measurement, or it is one of the world.
  if (moving.size() == 1 && residual->nodes.size() == 2 &&
      AddToOptimizer(residual->nodes, residual).ok()) {
    return Status::Ok();
  }
  status = AddToOptimizer(moving, residual);
  if (status.ok()) return status;
  if (moving.size() == 1) return Refuse(NameOf(id) + ": " + status.message());
  return Refuse(NameOf(id) + " depends on both poses and changes under a common motion (" +
                status.message() + ")");
}

// O(residuals), for messages.
template <typename G>
std::string KeptProblemOf<G>::NameOf(ceres::ResidualBlockId id) const {
  std::vector<ceres::ResidualBlockId> ids;
  problem_.GetResidualBlocks(&ids);
  return "residual " + std::to_string(std::find(ids.begin(), ids.end(), id) - ids.begin());
}

template <typename G>
Status KeptProblemOf<G>::Relink(NodeId id) {
  for (auto& [residual_id, residual] : residuals_) {
    if (std::find(residual.nodes.begin(), residual.nodes.end(), id) == residual.nodes.end()) {
      continue;
    }
    Unlink(residual);
    for (const NodeId node : residual.nodes) --nodes_.at(node).residuals;
    residual.nodes.clear();
    residual.edge = EdgeId();
    const Status status = Link(residual_id, &residual);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

template <typename G>
Status KeptProblemOf<G>::Look(const double* block) {
  const auto place = places_.find(block);
  if (place != places_.end()) return LookAtNode(place->second.node);
  return Status::Ok();
}

template <typename G>
Status KeptProblemOf<G>::LookAtAll() {
  ++looks_;
  std::vector<ceres::ResidualBlockId> ids, fresh, gone;
  problem_.GetResidualBlocks(&ids);
  for (const ceres::ResidualBlockId id : ids) {
    const auto it = residuals_.find(id);
    if (it == residuals_.end()) {
      fresh.push_back(id);
      continue;
    }
    const Residual now = Read(id);
    const Residual& known = it->second;
    if (now.cost == known.cost && now.loss == known.loss && now.blocks == known.blocks &&
        now.fingerprint == known.fingerprint) {
      it->second.seen = looks_;
    } else {
      fresh.push_back(id);
    }
  }
  for (const auto& [id, residual] : residuals_) {
    if (residual.seen != looks_) gone.push_back(id);
  }
  for (const ceres::ResidualBlockId id : gone) {
    const Status status = Remove(id);
    if (!status.ok()) return status;
  }
  std::vector<NodeId> nodes;
  for (const auto& [id, node] : nodes_) nodes.push_back(id);
  std::sort(nodes.begin(), nodes.end());
  for (const NodeId id : nodes) {
    const Status status = LookAtNode(id);
    if (!status.ok()) return status;
  }
  for (const ceres::ResidualBlockId id : fresh) {
    const Status status = Add(id);
    if (!status.ok()) return status;
  }
  return Status::Ok();
}

template <typename G>
UpdateReport KeptProblemOf<G>::Update(const UpdateLimits& limits) {
  const UpdateReport report = optimizer_.Update(limits);
  WriteBack();
  return report;
}

template <typename G>
UpdateReport KeptProblemOf<G>::Refine(const UpdateLimits& limits) {
  const UpdateReport report = optimizer_.Refine(limits);
  WriteBack();
  return report;
}

template <typename G>
Result<std::int64_t> KeptProblemOf<G>::GroupOf(const double* block, int level) const {
  const auto place = places_.find(block);
  if (place == places_.end()) return Status(StatusCode::kNotFound, "the block is of no pose");
  const auto group = optimizer_.GetGroup(place->second.node, level);
  if (!group.ok()) return group.status();
  return group->id;
}

template class KeptProblemOf<SE2>;
template class KeptProblemOf<SE3>;
template class KeptProblemOf<YawPose>;

}  // namespace hpgo
