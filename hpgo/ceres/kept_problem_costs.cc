// Costs of KeptProblemOf, as edges and priors of the optimizer.
#include <algorithm>
#include <utility>

#include "ceres/loss_function.h"
#include "ceres_costs/common_motion.h"
#include "hpgo/ceres/kept_problem.h"

namespace hpgo {

using ceres_costs::ErrorConvention;
using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;

namespace {

constexpr ErrorConvention kConventions[] = {ErrorConvention::kG2o, ErrorConvention::kSplitLog,
                                            ErrorConvention::kTwist};

}  // namespace

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

template class KeptProblemOf<SE2>;
template class KeptProblemOf<SE3>;
template class KeptProblemOf<YawPose>;

}  // namespace hpgo
