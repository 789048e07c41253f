#include "hpgo/ceres/secant_pairs.h"

#include <utility>

#include "Eigen/Core"

namespace hpgo {
namespace {

// Three do as well, and any number; each takes memory, and time in every step.
constexpr std::size_t kMostPairs = 5;

using Vector = Eigen::Map<Eigen::VectorXd>;
using ConstVector = Eigen::Map<const Eigen::VectorXd>;

ConstVector AsVector(const std::vector<double>& x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}

}  // namespace

void SecantPairs::Add(const std::vector<double>& step, const std::vector<double>& before,
                      const std::vector<double>& after) {
  constexpr double kLeastCosine = 1e-8;
  Pair pair;
  pair.step = step;
  pair.change.resize(step.size());
  Vector change(pair.change.data(), static_cast<Eigen::Index>(pair.change.size()));
  change = AsVector(after) - AsVector(before);
  pair.curvature = AsVector(step).dot(change);
  if (!(pair.curvature > kLeastCosine * AsVector(step).norm() * change.norm())) return;
  if (pairs_.size() == kMostPairs) pairs_.pop_front();
  pairs_.push_back(std::move(pair));
}

void SecantPairs::Solve(const std::function<void(double*)>& solve, std::vector<double>* x) const {
  Vector v(x->data(), static_cast<Eigen::Index>(x->size()));
  std::vector<double> along(pairs_.size());
  for (std::size_t k = pairs_.size(); k-- > 0;) {
    along[k] = AsVector(pairs_[k].step).dot(v) / pairs_[k].curvature;
    v -= along[k] * AsVector(pairs_[k].change);
  }
  solve(x->data());
  for (std::size_t k = 0; k < pairs_.size(); ++k) {
    const double missed = along[k] - AsVector(pairs_[k].change).dot(v) / pairs_[k].curvature;
    v += missed * AsVector(pairs_[k].step);
  }
}

}  // namespace hpgo
