#include "hpgo/solve/full_problem.h"

namespace hpgo {
template <typename G>
FullProblem<G>::FullProblem(const PoseGraph<G>& graph, const std::vector<int>& held,
                            const std::vector<bool>& robust, const ceres::LossFunction* loss,
                            ceres_costs::ErrorConvention convention)
    : robust_(robust), slots_(graph.nodes().size(), 0) {
  constexpr int kHeld = -1;
  for (const int node : held) slots_[node] = kHeld;
  int next = 0;
  for (int& slot : slots_) {
    if (slot != kHeld) slot = next++;
  }
  subproblem_.num_free = next;
  for (int& slot : slots_) {
    if (slot == kHeld) slot = next++;
  }
  subproblem_.poses.resize(slots_.size());

  // Reserved: the factors point to their elements.
  terms_.reserve(graph.edges().size() + graph.priors().size());
  offsets_.reserve(graph.priors().size());
  subproblem_.factors.reserve(graph.edges().size() + graph.priors().size());
  const auto add = [&](const G& measurement, const typename G::Matrix& information, int j) {
    terms_.push_back(
        {measurement.Normalized(), ceres_costs::PackedSymmetric<G::kDof>(information)});
    Factor<G>& factor = subproblem_.factors.emplace_back();
    factor.term = &terms_.back();
    factor.convention = convention;
    factor.j = slots_[j];
    return &factor;
  };
  for (std::size_t k = 0; k < graph.edges().size(); ++k) {
    const GraphEdge<G>& edge = graph.edges()[k];
    Factor<G>* factor = add(edge.measurement, edge.information, edge.j);
    factor->i = slots_[edge.i];
    if (robust[k]) factor->loss = loss;
  }
  for (const GraphPrior<G>& prior : graph.priors()) {
    offsets_.push_back(prior.offset.Normalized());
    add(prior.measurement, prior.information, prior.node)->offset = &offsets_.back();
  }
}

template <typename G>
void FullProblem<G>::SetPoses(const std::vector<G>& poses) {
  for (std::size_t node = 0; node < slots_.size(); ++node) {
    subproblem_.poses[slots_[node]] = poses[node].Normalized();
  }
}

template <typename G>
void FullProblem<G>::SetLoss(const ceres::LossFunction* loss) {
  for (std::size_t k = 0; k < robust_.size(); ++k) {  // the edges' factors are the first
    if (robust_[k]) subproblem_.factors[k].loss = loss;
  }
}

template <typename G>
double FullProblem<G>::Sum(bool with_loss) const {
  double sum = 0;
  for (const Factor<G>& factor : subproblem_.factors) {
    ceres_costs::FactorTerm<G> term = factor;
    if (!with_loss) term.loss = nullptr;
    const bool unary = factor.i == kWorldFrame;
    const G& X_j = subproblem_.poses[factor.j];
    sum += FactorCost(term, unary, unary ? X_j : subproblem_.poses[factor.i].Between(X_j));
  }
  return sum;
}

template class FullProblem<SE2>;
template class FullProblem<SE3>;
template class FullProblem<YawPose>;

}  // namespace hpgo
