#include "hpgo/ceres/kept_problem.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "ceres/loss_function.h"
#include "ceres_costs/common_motion.h"
#include "hpgo/ceres/problem_view.h"

namespace hpgo {
namespace {

using ceres_costs::ErrorConvention;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

Status Refuse(const std::string& reason) { return Status(StatusCode::kInvalidArgument, reason); }

void Mix(double value, std::uint64_t* hash) {
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof(bits));
  *hash = (*hash ^ bits) * 0x9e3779b97f4a7c15u;
  *hash ^= *hash >> 29;
}

constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kSplitLog,
                                            ErrorConvention::kTwist};

}  // namespace

std::uint64_t Fingerprint(const ceres::CostFunction& cost, const ceres::LossFunction* loss) {
  std::vector<double> values;
  std::vector<std::size_t> begins;
  for (const int size : cost.parameter_block_sizes()) {
    begins.push_back(values.size());
    double norm = 0;
    for (int k = 0; k < size; ++k) {
      values.push_back(std::cos(1.0 + static_cast<double>(values.size())));
      norm += values.back() * values.back();
    }
    if (size < 4) continue;  // may hold a quaternion
    for (int k = 0; k < size; ++k) values[begins.back() + k] /= std::sqrt(norm);
  }
  std::vector<const double*> parameters;
  for (const std::size_t begin : begins) parameters.push_back(&values[begin]);
  std::vector<double> residuals(cost.num_residuals());
  std::uint64_t hash = residuals.size();
  if (cost.Evaluate(parameters.data(), residuals.data(), nullptr)) {
    for (const double r : residuals) Mix(r, &hash);
  }
  for (const double s : {0.5, 5., 500.}) {
    double rho[3] = {s, 1, 0};
    if (loss != nullptr) loss->Evaluate(s, rho);
    Mix(rho[0], &hash);
  }
  return hash;
}

template <typename G>
KeptProblemOf<G>::KeptProblemOf(ceres::Problem* problem, const OptimizerOptions& options,
                                const PoseLayout& layout)
    : problem_(*problem), codec_(layout), optimizer_(options) {}

template <typename G>
int KeptProblemOf<G>::OffsetOf(int k) const {
  int offset = 0;
  for (int p = 0; p < k; ++p) offset += layout().sizes[p];
  return offset;
}

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
Status KeptProblemOf<G>::FindNodes(ceres::ResidualBlockId id, Residual* residual) {
  const std::vector<int>& sizes = layout().sizes;
  const auto note = [&](NodeId node) {
    if (std::find(residual->nodes.begin(), residual->nodes.end(), node) == residual->nodes.end()) {
      residual->nodes.push_back(node);
    }
  };
  for (std::size_t k = 0; k < residual->blocks.size();) {
    const auto known = places_.find(residual->blocks[k]);
    if (known != places_.end()) {
      note(known->second.node);
      ++k;
      continue;
    }
    bool matches = k + sizes.size() <= residual->blocks.size();
    for (std::size_t p = 0; matches && p < sizes.size(); ++p) {
      matches = problem_.ParameterBlockSize(residual->blocks[k + p]) == sizes[p] &&
                places_.count(residual->blocks[k + p]) == 0;
    }
    if (matches) {
      NodeId node;
      const Status status =
          AddNode({residual->blocks.begin() + static_cast<std::ptrdiff_t>(k),
                   residual->blocks.begin() + static_cast<std::ptrdiff_t>(k + sizes.size())},
                  &node);
      if (!status.ok()) return status;
      note(node);
      k += sizes.size();
    } else if (problem_.IsParameterBlockConstant(residual->blocks[k])) {
      ++k;
    } else {
      return Refuse("block " + std::to_string(k) + " (size " +
                    std::to_string(problem_.ParameterBlockSize(residual->blocks[k])) + ") of " +
                    NameOf(id) + " belongs to no pose");
    }
  }
  return Status::Ok();
}

template <typename G>
Status KeptProblemOf<G>::AddNode(const std::vector<double*>& blocks, NodeId* id) {
  Node node;
  node.blocks = blocks;
  std::size_t held = 0;
  for (const double* block : blocks) {
    const int size = problem_.ParameterBlockSize(block);
    if (IsBounded(problem_, block, size)) return Refuse("bounds on a pose");
    held += problem_.IsParameterBlockConstant(block);
    node.manifolds.push_back(problem_.GetManifold(block));
    node.numbers.insert(node.numbers.end(), block, block + size);
    const ceres::Manifold* manifold = node.manifolds.back();
    node.true_jacobians.push_back(manifold == nullptr || HasTrueJacobian(*manifold, block));
    // Of the numbers of a quaternion one is not free.
    const bool quaternion = G::kParams == 7 && size >= 4;
    const bool full = manifold == nullptr || manifold->TangentSize() == size - quaternion;
    if (!full && !problem_.IsParameterBlockConstant(block)) return Refuse("pose partly constant");
  }
  if (held > 0 && held < blocks.size()) return Refuse("pose partly constant");
  node.fixed = held > 0;
  *id = next_node_++;
  Status status = optimizer_.AddNode(*id, codec_.Read(node.numbers.data()));
  if (status.ok() && node.fixed) status = optimizer_.SetFixed(*id, true);
  if (!status.ok()) return status;
  for (std::size_t k = 0; k < blocks.size(); ++k) {
    places_[blocks[k]] = {*id, static_cast<int>(k)};
  }
  nodes_[*id] = std::move(node);
  return Status::Ok();
}

template <typename G>
std::vector<BlockSource> KeptProblemOf<G>::Sources(const Residual& residual,
                                                   const std::vector<NodeId>& poses) const {
  std::vector<BlockSource> sources;
  for (const double* block : residual.blocks) {
    BlockSource source;
    source.size = problem_.ParameterBlockSize(block);
    source.values = block;
    const auto place = places_.find(block);
    if (place != places_.end()) {
      const auto at = std::find(poses.begin(), poses.end(), place->second.node);
      const Node& node = nodes_.at(place->second.node);
      if (at != poses.end()) {
        source.pose = static_cast<int>(at - poses.begin());
        source.offset = OffsetOf(place->second.k);
        source.manifold = node.manifolds[place->second.k];
        source.true_jacobian = node.true_jacobians[place->second.k];
      }
    }
    sources.push_back(source);
  }
  return sources;
}

template <typename G>
Status KeptProblemOf<G>::AddToOptimizer(const std::vector<NodeId>& poses, Residual* residual) {
  const bool unary = poses.size() == 1;
  const std::vector<BlockSource> sources = Sources(*residual, poses);
  // Values of held blocks may be rewritten: such a cost is read anew at every evaluation.
  const bool reads_others = std::any_of(sources.begin(), sources.end(),
                                        [](const BlockSource& source) { return source.pose < 0; });
  const auto cost = std::make_shared<const AdaptedCost<G>>(residual->cost, codec_,
                                                           static_cast<int>(poses.size()), sources);
  std::shared_ptr<const ceres::LossFunction> loss;
  if (residual->loss != nullptr) loss.reset(residual->loss, [](const ceres::LossFunction*) {});
  const G X_j = *optimizer_.GetPose(poses.back());
  const G T = unary ? X_j : optimizer_.GetPose(poses[0])->Between(X_j);
  const std::optional<LeastCost<G>> found = FindLeastCost<G>(*cost, unary, T);
  const LeastCost<G> least = found.value_or(LeastCost<G>());
  if (unary) {
    return Take(optimizer_.AddCustomPrior(poses[0], cost, least.T, least.information, loss),
                residual);
  }
  if (found.has_value() && !reads_others && ceres_costs::CommonMotionProblem<G>(*cost, T).empty()) {
    NoteConventions(*cost, least);
    const auto term = AsTerm(*cost, least, optimizer_.options().convention);
    if (term.has_value()) {
      const Result<EdgeId> edge = optimizer_.AddEdge(poses[0], poses[1], term->measurement,
                                                     term->information.Dense(), loss);
      if (edge.ok()) return Take(edge, residual);
    }
  }
  return Take(optimizer_.AddCustomEdge(poses[0], poses[1], cost, least.T, least.information, loss),
              residual);
}

template <typename G>
Status KeptProblemOf<G>::Take(const Result<EdgeId>& edge, Residual* residual) {
  if (!edge.ok()) return edge.status();
  residual->edge = *edge;
  return Status::Ok();
}

// The first ones tell what the others are like.
template <typename G>
void KeptProblemOf<G>::NoteConventions(const ceres::CostFunction& cost, const LeastCost<G>& least) {
  if (HasSampled()) return;
  ++sampled_;
  for (const ErrorConvention convention : kConventions) {
    matches_[static_cast<int>(convention)] += AsTerm(cost, least, convention).has_value();
  }
}

template <typename G>
ErrorConvention KeptProblemOf<G>::BestConvention() const {
  ErrorConvention best = optimizer_.options().convention;
  for (const ErrorConvention convention : kConventions) {
    if (matches_[static_cast<int>(convention)] > matches_[static_cast<int>(best)]) {
      best = convention;
    }
  }
  return best;
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
Status KeptProblemOf<G>::LookAtNode(NodeId id) {
  Node& node = nodes_.at(id);
  std::size_t held = 0;
  bool moved = false;
  for (std::size_t k = 0; k < node.blocks.size(); ++k) {
    const double* block = node.blocks[k];
    if (!problem_.HasParameterBlock(block))
      return Refuse("a block was removed under its residuals");
    held += problem_.IsParameterBlockConstant(block);
    if (problem_.GetManifold(block) != node.manifolds[k]) return Refuse("a manifold was replaced");
    const int size = layout().sizes[k];
    double* numbers = &node.numbers[OffsetOf(static_cast<int>(k))];
    if (std::memcmp(numbers, block, sizeof(double) * size) == 0) continue;
    std::copy_n(block, size, numbers);
    moved = true;
  }
  if (held > 0 && held < node.blocks.size()) return Refuse("pose partly constant");
  if (moved) {
    const Status status = optimizer_.SetPose(id, codec_.Read(node.numbers.data()));
    if (!status.ok()) return status;
  }
  if (node.fixed == (held > 0)) return Status::Ok();
  node.fixed = held > 0;
  const Status status = optimizer_.SetFixed(id, node.fixed);
  return status.ok() ? Relink(id) : status;
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
void KeptProblemOf<G>::WriteBack() {
  constexpr double kDistance = 1e-10, kAngle = 1e-10;  // m, rad
  optimizer_.ForEachMoved(kDistance, kAngle, [&](NodeId id, const G& pose) {
    Node& node = nodes_.at(id);
    if (node.fixed) return;
    codec_.Write(pose, node.numbers.data());
    for (std::size_t k = 0; k < node.blocks.size(); ++k) {
      std::copy_n(&node.numbers[OffsetOf(static_cast<int>(k))], layout().sizes[k], node.blocks[k]);
    }
  });
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
