// Poses of KeptProblemOf: found among the blocks of the problem, looked at again, written back.
#include <algorithm>
#include <cstring>

#include "hpgo/ceres/kept_problem.h"
#include "hpgo/ceres/problem_view.h"

namespace hpgo {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

Status Refuse(const std::string& reason) { return Status(StatusCode::kInvalidArgument, reason); }

}  // namespace

template <typename G>
int KeptProblemOf<G>::OffsetOf(int k) const {
  int offset = 0;
  for (int p = 0; p < k; ++p) offset += layout().sizes[p];
  return offset;
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

template class KeptProblemOf<SE2>;
template class KeptProblemOf<SE3>;
template class KeptProblemOf<YawPose>;

}  // namespace hpgo
