// Subproblems over small graphs, for the tests of the engines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "hpgo/graph/pose_graph.h"
#include "hpgo/solve/subproblem.h"

namespace hpgo {

// A Subproblem over the graph's edges in which the last pose is constant.
template <typename G>
struct Problem {
  explicit Problem(const PoseGraph<G>& graph) {
    for (const GraphNode<G>& node : graph.nodes()) subproblem.poses.push_back(node.pose);
    subproblem.num_free = static_cast<int>(subproblem.poses.size()) - 1;
    terms.reserve(graph.edges().size() + 1);
    for (const GraphEdge<G>& edge : graph.edges()) {
      terms.push_back({edge.measurement, ceres_costs::PackedSymmetric<G::kDof>(edge.information)});
      Factor<G>& factor = subproblem.factors.emplace_back();
      factor.term = &terms.back();
      factor.i = edge.i;
      factor.j = edge.j;
    }
  }
  Problem(const Problem&) = delete;  // the factors point into it
  Problem& operator=(const Problem&) = delete;

  double Cost() const {
    double sum = 0;
    for (const Factor<G>& factor : subproblem.factors) {
      const bool unary = factor.i == kWorldFrame;
      const G& X_j = subproblem.poses[factor.j];
      sum += ceres_costs::FactorCost<G>(factor, unary,
                                        unary ? X_j : subproblem.poses[factor.i].Between(X_j));
    }
    return sum;
  }

  std::vector<ceres_costs::RelativePoseTerm<G>> terms;
  Subproblem<G> subproblem;
};

// The largest |tangent| between two poses; a NaN stays.
template <typename G>
double Distance(const std::vector<G>& a, const std::vector<G>& b) {
  double largest = a.size() == b.size() ? 0 : NAN;
  for (std::size_t k = 0; k < a.size(); ++k) {
    const double d = a[k].LocalCoordinates(b[k]).norm();
    if (!(d <= largest)) largest = d;
  }
  return largest;
}

template <typename G>
bool SameBits(const std::vector<G>& a, const std::vector<G>& b) {
  if (a.size() != b.size()) return false;
  if (a.empty()) return true;  // memcmp must not be given null
  return std::memcmp(static_cast<const void*>(a.data()), static_cast<const void*>(b.data()),
                     sizeof(G) * a.size()) == 0;
}

// Over two poses; fails from the `good`-th evaluation on.
template <typename G>
class FailingCost final : public ceres::CostFunction {
 public:
  explicit FailingCost(int good) : good_(good) {
    set_num_residuals(1);
    mutable_parameter_block_sizes()->assign(2, G::kParams);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    if (calls_++ >= good_) return false;
    residuals[0] = parameters[1][0] - 3;
    for (int b = 0; jacobians != nullptr && b < 2; ++b) {
      if (jacobians[b] == nullptr) continue;
      std::fill(jacobians[b], jacobians[b] + G::kParams, 0.0);
      if (b == 1) jacobians[b][0] = 1;
    }
    return true;
  }

 private:
  const int good_;
  mutable int calls_ = 0;
};

}  // namespace hpgo
