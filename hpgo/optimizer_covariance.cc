// Optimizer: covariances, exact and in bounded time.

#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/marginal.h"
#include "hpgo/solve/neighborhood.h"

namespace hpgo {
namespace {

// Of a pose of a problem; of a constant one 0: it is known exactly.
template <typename G>
Result<typename G::Matrix> CovarianceAt(const Subproblem<G>& problem, int index) {
  using Matrix = typename G::Matrix;
  return index < problem.num_free ? MarginalCovariance(problem, index)
                                  : Result<Matrix>(Matrix(Matrix::Zero()));
}

// With right perturbations d_i, d_j of the poses, that of T = X_i^-1 X_j is d_j - Ad(T^-1) d_i.
template <typename G>
Result<typename G::Matrix> CovarianceBetween(const Subproblem<G>& problem, int i, int j) {
  using Matrix = typename G::Matrix;
  constexpr int D = G::kDof;
  const G T = problem.poses[i].Between(problem.poses[j]);
  std::vector<int> indices;
  Eigen::Matrix<double, D, Eigen::Dynamic> J(D, 0);
  const auto add = [&](int index, const Matrix& jacobian) {
    if (index >= problem.num_free) return;  // held: known exactly
    indices.push_back(index);
    J.conservativeResize(D, J.cols() + D);
    J.template rightCols<D>() = jacobian;
  };
  add(i, -T.Inverse().Adjoint());
  add(j, Matrix::Identity());
  if (indices.empty()) return Matrix(Matrix::Zero());
  const Result<Eigen::MatrixXd> joint = JointCovariance(problem, indices);
  if (!joint.ok()) return joint.status();
  return Matrix(J * *joint * J.transpose());
}

}  // namespace

// All that the nodes hang together with, up to constant nodes: the free poses first. O(component).
template <typename G>
Subproblem<G> Optimizer<G>::Impl::ComponentsOf(const std::vector<Index>& nodes,
                                               std::unordered_map<Index, int>* position) const {
  const auto is_held = [&](Index node) { return graph_.IsHeld(node); };
  std::vector<Index> free, held;
  const auto add = [&](Index node) {
    std::vector<Index>& list = is_held(node) ? held : free;
    if (position->emplace(node, static_cast<int>(list.size())).second) list.push_back(node);
  };
  for (const Index node : nodes) add(node);
  for (std::size_t k = 0; k < free.size(); ++k) {
    graph_.ForEachEdgeOf(free[k], [&](Index, Index other) {
      if (other != kNone) add(other);
    });
  }
  Subproblem<G> problem;
  problem.num_free = static_cast<int>(free.size());
  for (const Index node : held) (*position)[node] += problem.num_free;
  for (const Index node : free) problem.poses.push_back(graph_.WorldPose(node));
  for (const Index node : held) problem.poses.push_back(graph_.WorldPose(node));
  for (const Index node : free) {
    graph_.ForEachEdgeOf(node, [&](Index edge, Index other) {
      // One between free nodes comes with its first end.
      if (other != kNone && !is_held(other) && graph_.End(edge, 0) != node) return;
      Factor<G> factor;
      static_cast<ceres_costs::FactorTerm<G>&>(factor) = graph_.FactorOf(edge);
      if (graph_.End(edge, 0) != kNone) factor.i = position->at(graph_.End(edge, 0));
      factor.j = position->at(graph_.End(edge, 1));
      problem.factors.push_back(factor);
    });
  }
  return problem;
}

template <typename G>
Result<typename G::Matrix> Optimizer<G>::Impl::MarginalCovariance(NodeId id) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  std::unordered_map<Index, int> position;
  const Subproblem<G> problem = ComponentsOf({*node}, &position);
  return CovarianceAt(problem, position.at(*node));
}

template <typename G>
Result<typename G::Matrix> Optimizer<G>::Impl::RelativeCovariance(NodeId i, NodeId j) const {
  const Result<Index> a = FindNode(i), b = FindNode(j);
  if (!a.ok()) return a.status();
  if (!b.ok()) return b.status();
  if (i == j) return Matrix(Matrix::Zero());
  std::unordered_map<Index, int> position;
  const Subproblem<G> problem = ComponentsOf({*a, *b}, &position);
  return CovarianceBetween(problem, position.at(*a), position.at(*b));
}

template <typename G>
Result<typename Optimizer<G>::CovarianceEstimate> Optimizer<G>::Impl::BoundedMarginalCovariance(
    NodeId id, int max_nodes) const {
  const Result<Index> node = FindNode(id);
  if (!node.ok()) return node.status();
  if (graph_.IsHeld(*node)) return CovarianceEstimate{Matrix::Zero(), true, 0};
  Neighborhood<G> near;
  const Status status = FindNeighborhood<G>({*node}, max_nodes, &graph_, &near);
  if (!status.ok()) return status;
  const Result<Matrix> covariance = CovarianceAt(near.problem(), near.indices[0]);
  if (!covariance.ok()) return covariance.status();
  return CovarianceEstimate{*covariance, near.whole, near.problem().num_free};
}

template <typename G>
Result<typename Optimizer<G>::CovarianceEstimate> Optimizer<G>::Impl::BoundedRelativeCovariance(
    NodeId i, NodeId j, int max_nodes) const {
  const Result<Index> a = FindNode(i), b = FindNode(j);
  if (!a.ok()) return a.status();
  if (!b.ok()) return b.status();
  if (i == j) return CovarianceEstimate{Matrix::Zero(), true, 0};
  Neighborhood<G> near;
  const Status status = FindNeighborhood<G>({*a, *b}, max_nodes, &graph_, &near);
  if (!status.ok()) return status;
  const Result<Matrix> covariance =
      CovarianceBetween(near.problem(), near.indices[0], near.indices[1]);
  if (!covariance.ok()) return covariance.status();
  return CovarianceEstimate{*covariance, near.whole, near.problem().num_free};
}

template <typename G>
Result<typename G::Matrix> Optimizer<G>::MarginalCovariance(NodeId id) const {
  return impl_->MarginalCovariance(id);
}
template <typename G>
Result<typename G::Matrix> Optimizer<G>::RelativeCovariance(NodeId i, NodeId j) const {
  return impl_->RelativeCovariance(i, j);
}

template <typename G>
Result<typename Optimizer<G>::CovarianceEstimate> Optimizer<G>::BoundedMarginalCovariance(
    NodeId id, int max_nodes) const {
  return impl_->BoundedMarginalCovariance(id, max_nodes);
}
template <typename G>
Result<typename Optimizer<G>::CovarianceEstimate> Optimizer<G>::BoundedRelativeCovariance(
    NodeId i, NodeId j, int max_nodes) const {
  return impl_->BoundedRelativeCovariance(i, j, max_nodes);
}

template class Optimizer<SE2>;
template class Optimizer<SE3>;
template class Optimizer<YawPose>;

}  // namespace hpgo
