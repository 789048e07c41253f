// Optimizer: exact covariances.

#include "hpgo/optimizer_impl.h"
#include "hpgo/solve/marginal.h"

namespace hpgo {

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
  const int index = position.at(*node);
  if (index >= problem.num_free) return Matrix(Matrix::Zero());  // it is held: known exactly
  return hpgo::MarginalCovariance(problem, index);
}

// With right perturbations d_i, d_j of the poses, that of T = X_i^-1 X_j is d_j - Ad(T^-1) d_i.
template <typename G>
Result<typename G::Matrix> Optimizer<G>::Impl::RelativeCovariance(NodeId i, NodeId j) const {
  constexpr int D = G::kDof;
  const Result<Index> a = FindNode(i), b = FindNode(j);
  if (!a.ok()) return a.status();
  if (!b.ok()) return b.status();
  if (i == j) return Matrix(Matrix::Zero());
  std::unordered_map<Index, int> position;
  const Subproblem<G> problem = ComponentsOf({*a, *b}, &position);
  const G T = graph_.WorldPose(*a).Between(graph_.WorldPose(*b));
  std::vector<int> indices;
  Eigen::Matrix<double, D, Eigen::Dynamic> J(D, 0);
  const auto add = [&](Index node, const Matrix& jacobian) {
    if (position.at(node) >= problem.num_free) return;  // held: known exactly
    indices.push_back(position.at(node));
    J.conservativeResize(D, J.cols() + D);
    J.template rightCols<D>() = jacobian;
  };
  add(*a, -T.Inverse().Adjoint());
  add(*b, Matrix::Identity());
  if (indices.empty()) return Matrix(Matrix::Zero());
  const Result<Eigen::MatrixXd> joint = JointCovariance(problem, indices);
  if (!joint.ok()) return joint.status();
  return Matrix(J * *joint * J.transpose());
}

template <typename G>
Result<typename G::Matrix> Optimizer<G>::MarginalCovariance(NodeId id) const {
  return impl_->MarginalCovariance(id);
}
template <typename G>
Result<typename G::Matrix> Optimizer<G>::RelativeCovariance(NodeId i, NodeId j) const {
  return impl_->RelativeCovariance(i, j);
}

template class Optimizer<SE2>::Impl;
template class Optimizer<SE3>::Impl;
template class Optimizer<SE2>;
template class Optimizer<SE3>;

}  // namespace hpgo
