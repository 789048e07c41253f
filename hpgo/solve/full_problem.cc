#include "hpgo/solve/full_problem.h"

#include <string>

#include "ceres_costs/relative_pose_cost.h"

namespace hpgo {
namespace {

// Relative to the largest entry: what rounding leaves of a symmetric matrix.
constexpr double kSymmetryTolerance = 1e-9;

// Why the value cannot be solved with, or an empty string.
std::string PoseProblem(const SE2& pose) {
  return Eigen::Map<const Eigen::Vector3d>(pose.data()).allFinite() ? "" : "is not finite";
}
std::string PoseProblem(const SE3& pose) {
  if (!Eigen::Map<const Eigen::Matrix<double, 7, 1>>(pose.data()).allFinite()) {
    return "is not finite";
  }
  return pose.rotation().norm() > 0 ? "" : "has a zero quaternion";
}

template <typename G>
std::string InformationProblem(const typename G::Matrix& information) {
  if (!information.allFinite()) return "the information matrix has an entry that is not finite";
  if ((information - information.transpose()).cwiseAbs().maxCoeff() >
      kSymmetryTolerance * information.cwiseAbs().maxCoeff()) {
    return "the information matrix is not symmetric";
  }
  ceres_costs::RelativePoseTerm<G> term;
  term.information = ceres_costs::PackedSymmetric<G::kDof>(information);
  typename G::Matrix W;
  std::string error;
  return ceres_costs::WhitenTerm(term, &W, &error) ? "" : error;
}

template <typename G>
std::string MeasurementProblem(const G& measurement, const typename G::Matrix& information) {
  const std::string problem = PoseProblem(measurement);
  if (!problem.empty()) return "the measurement " + problem;
  return InformationProblem<G>(information);
}

}  // namespace

template <typename G>
Status CheckGraph(const PoseGraph<G>& graph) {
  const auto id = [&](int index) { return std::to_string(graph.nodes()[index].id); };
  for (const GraphNode<G>& node : graph.nodes()) {
    if (!node.has_pose) continue;
    const std::string problem = PoseProblem(node.pose);
    if (problem.empty()) continue;
    return Status(StatusCode::kInvalidArgument,
                  "node " + std::to_string(node.id) + ": the pose " + problem);
  }
  for (const GraphEdge<G>& edge : graph.edges()) {
    const std::string problem = MeasurementProblem(edge.measurement, edge.information);
    if (problem.empty()) continue;
    return Status(StatusCode::kInvalidArgument,
                  "edge " + id(edge.i) + " -> " + id(edge.j) + ": " + problem);
  }
  for (const GraphPrior<G>& prior : graph.priors()) {
    std::string problem = MeasurementProblem(prior.measurement, prior.information);
    if (problem.empty()) {
      problem = PoseProblem(prior.offset);
      if (problem.empty()) continue;
      problem = "the offset " + problem;
    }
    return Status(StatusCode::kInvalidArgument, "prior of node " + id(prior.node) + ": " + problem);
  }
  return Status::Ok();
}

template <typename G>
FullProblem<G>::FullProblem(const PoseGraph<G>& graph, const std::vector<int>& held,
                            const std::vector<bool>& robust, const ceres::LossFunction* loss,
                            ceres_costs::ErrorConvention convention)
    : slots_(graph.nodes().size(), 0) {
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

template Status CheckGraph(const PoseGraph<SE2>&);
template Status CheckGraph(const PoseGraph<SE3>&);
template class FullProblem<SE2>;
template class FullProblem<SE3>;

}  // namespace hpgo
