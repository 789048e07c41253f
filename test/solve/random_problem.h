// Random problems with everything that an engine must take, for the tests of the block engine.
#pragma once

#include <cmath>
#include <deque>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "ceres/autodiff_cost_function.h"
#include "ceres_costs/losses.h"
#include "gtest/gtest.h"
#include "hpgo/solve/subproblem.h"
#include "small_graphs.h"

namespace hpgo {

// The distance of two poses from what was measured.
template <typename G>
struct DistanceError {
  double measured;
  template <typename S>
  bool operator()(const S* i, const S* j, S* residual) const {
    using std::sqrt;
    S squares(1e-6);  // smooth at zero
    for (int k = 0; k < G::kDim; ++k) squares += (i[k] - j[k]) * (i[k] - j[k]);
    residual[0] = 3.0 * (sqrt(squares) - measured);
    return true;
  }
};

// A connected graph with everything that factors can have: edges in both directions and parallel,
// also between constant poses; full and partial priors with and without offsets; semi-definite
// edges, losses, custom costs, every convention.
template <typename G>
class RandomProblem {
 public:
  explicit RandomProblem(unsigned seed) : rng_(seed) {
    const int n = Uniform(1, 60), constant = Uniform(0, 3);
    const ceres_costs::ErrorConvention convention =
        static_cast<ceres_costs::ErrorConvention>(Uniform(0, 2));
    std::string error;
    EXPECT_TRUE(ceres_costs::MakeLoss("huber", 3, &losses_[1], &error)) << error;
    EXPECT_TRUE(ceres_costs::MakeLoss("cauchy", 5, &losses_[2], &error)) << error;
    std::vector<G> truth;
    for (int k = 0; k < n + constant; ++k) truth.push_back(RandomPose<G>(&rng_, 4, 2));
    const auto edge = [&](int i, int j, bool partial) {
      Factor<G> factor;
      factor.i = i;
      factor.j = j;
      factor.convention = convention;
      factor.loss = losses_[Uniform(0, 2)].get();
      factor.term = Term(truth[i].Between(truth[j]), partial);
      problem.factors.push_back(factor);
    };
    for (int k = 1; k < n; ++k) {
      const int other = Uniform(0, k - 1);
      k % 2 == 0 ? edge(k, other, false) : edge(other, k, false);
    }
    for (int k = 0; k < 2 * n; ++k) {
      const int i = Uniform(0, n + constant - 1), j = Uniform(0, n + constant - 1);
      if (i != j) edge(i, j, k % 3 == 0);
      if (i != j && k % 5 == 0) edge(j, i, false);
    }
    for (int k = n; k < n + constant; ++k) edge(Uniform(0, n - 1), k, false);
    // A constant pose or a prior holds the gauge.
    for (int k = constant > 0 ? Uniform(-2, 2) : 1; k > 0; --k) {
      Factor<G> factor;
      factor.j = Uniform(0, n - 1);
      factor.convention = convention;
      G offset;
      if (k % 2 == 0) {
        offset = RandomPose<G>(&rng_, 1, 1);
        factor.offset = &offsets_.emplace_back(offset);
      }
      const bool partial = k > 1;  // of the position only: with kTwist it would turn with the rest
      factor.term = Term(truth[factor.j] * offset,
                         partial && convention != ceres_costs::ErrorConvention::kTwist);
      problem.factors.push_back(factor);
    }
    for (int k = 0; k < n / 10; ++k) {
      const int i = Uniform(0, n - 1), j = Uniform(0, n - 1);
      if (i == j) continue;
      const double distance = (truth[i].translation() - truth[j].translation()).norm();
      costs_.push_back(std::make_unique<
                       ceres::AutoDiffCostFunction<DistanceError<G>, 1, G::kParams, G::kParams>>(
          new DistanceError<G>{distance + 0.1}));
      Factor<G> factor;
      factor.i = i;
      factor.j = j;
      factor.custom = costs_.back().get();
      problem.factors.push_back(factor);
    }
    for (int k = 0; k < n + constant; ++k) {
      problem.poses.push_back(k < n ? truth[k] * RandomPose<G>(&rng_, 0.1, 0.1) : truth[k]);
    }
    problem.num_free = n;
  }

  Subproblem<G> problem;

 private:
  int Uniform(int low, int high) { return std::uniform_int_distribution<int>(low, high)(rng_); }

  // Of an edge: noisy, with dense information; `partial`: of the translation alone.
  const ceres_costs::RelativePoseTerm<G>* Term(const G& T, bool partial) {
    typename G::Matrix information = 10 * RandomInformation<G>(&rng_);
    if (partial) {
      information.template bottomRows<G::kRotationDof>().setZero();
      information.template rightCols<G::kRotationDof>().setZero();
    }
    return &terms_.emplace_back(ceres_costs::RelativePoseTerm<G>{
        T * RandomPose<G>(&rng_, 0.05, 0.05), ceres_costs::PackedSymmetric<G::kDof>(information)});
  }

  std::mt19937_64 rng_;
  std::deque<ceres_costs::RelativePoseTerm<G>> terms_;
  std::deque<G> offsets_;
  std::unique_ptr<ceres::LossFunction> losses_[3];
  std::vector<std::unique_ptr<ceres::CostFunction>> costs_;
};

}  // namespace hpgo
