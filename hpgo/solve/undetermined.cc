#include "hpgo/solve/undetermined.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "ceres_costs/whitening.h"
#include "hpgo/solve/block_system.h"

namespace hpgo {
namespace {

// Of springs laid beside soft factors, against what those measure best.
constexpr double kStiff = 1e-8, kLessStiff = 1e-10;
// The share of its motion on the stiff springs that an open pose makes on the less stiff ones; one
// that is held makes a hundredth.
constexpr double kSameMotion = 0.1;
// Of the largest motion: less is rounding.
constexpr double kRounding = 1e-6;

// Whether a factor measures less than all directions, but for rounding.
template <typename G>
bool IsSoft(const Factor<G>& factor) {
  return factor.custom != nullptr ||
         ceres_costs::ClassifyInformation<G::kDof>(factor.term->information.Dense()) !=
             ceres_costs::InformationKind::kPositiveDefinite;
}

// Poses on springs. Where a factor leaves a direction open, nothing but the spring beside it
// decides: the poses go all the way to where it wants them, however weak it is.
template <typename G>
class Springs {
 public:
  explicit Springs(const Subproblem<G>& problem) : bare_(problem) {
    for (Factor<G>& factor : bare_.factors) {
      factor.loss = nullptr;
      if (IsSoft(factor)) soft_.push_back(factor);
    }
    if (none()) return;
    BlockSystem<G> system;
    system.Analyze(&bare_);
    finite_ = std::isfinite(system.Linearize(Hessian::kAsMeasured));
    gradient_ = system.gradient();
  }
  bool none() const { return soft_.empty(); }

  // How far each free pose goes, translation and rotation, by springs that want each factor's poses
  // elsewhere by chance. Empty where that cannot be told.
  std::vector<std::array<double, 2>> Motions(double stiffness) {
    std::mt19937_64 rng(1);
    std::normal_distribution<double> normal(0, 0.1);
    std::vector<ceres_costs::RelativePoseTerm<G>> terms;
    terms.reserve(soft_.size());
    Subproblem<G> sprung = bare_;
    for (const Factor<G>& factor : soft_) {
      const bool unary = factor.i == kWorldFrame;
      const G T = RelativePose(factor, bare_.poses);
      ceres_costs::QuadraticModel<G> model;
      if (!LinearizeFactor(factor, unary, T, &model)) return {};
      typename G::Tangent best = BestOfKind<G>(model.A), wanted;
      if (best.isZero(0)) best.setOnes();
      for (int c = 0; c < G::kDof; ++c) wanted(c) = normal(rng);
      terms.push_back({T.Retract(wanted), ceres_costs::PackedSymmetric<G::kDof>(
                                              typename G::Matrix(stiffness * best.asDiagonal()))});
      Factor<G> spring;
      spring.term = &terms.back();
      spring.i = factor.i;
      spring.j = factor.j;
      sprung.factors.push_back(spring);
    }
    BlockSystem<G> system;
    system.Analyze(&sprung);
    if (!finite_ || !std::isfinite(system.Linearize(Hessian::kAsMeasured)) ||
        !system.Factorize(0)) {
      return {};
    }
    std::vector<double> step = gradient_;
    for (std::size_t k = 0; k < step.size(); ++k) step[k] -= system.gradient()[k];
    system.Solve(step.data());
    std::vector<std::array<double, 2>> motions(bare_.num_free);
    for (int k = 0; k < bare_.num_free; ++k) {
      const Eigen::Map<typename G::Tangent> d(&step[static_cast<std::size_t>(k) * G::kDof]);
      motions[k] = {d.template head<G::kDim>().norm(), d.template tail<G::kRotationDof>().norm()};
    }
    return motions;
  }

 private:
  Subproblem<G> bare_;  // without losses
  std::vector<Factor<G>> soft_;
  bool finite_ = false;           // whether every cost of bare_ can be evaluated
  std::vector<double> gradient_;  // of bare_
};

}  // namespace

template <typename G>
std::vector<int> FindUndetermined(const Subproblem<G>& problem) {
  std::vector<int> undetermined;
  Springs<G> springs(problem);
  if (problem.num_free == 0 || springs.none()) return undetermined;
  const auto stiff = springs.Motions(kStiff), soft = springs.Motions(kLessStiff);
  if (stiff.empty() || soft.empty()) return undetermined;
  std::array<double, 2> largest = {0, 0};
  for (const auto& motion : soft) {
    for (int kind = 0; kind < 2; ++kind) largest[kind] = std::max(largest[kind], motion[kind]);
  }
  for (int k = 0; k < problem.num_free; ++k) {
    bool open = false;
    for (int kind = 0; kind < 2; ++kind) {
      open |=
          soft[k][kind] > kSameMotion * stiff[k][kind] && soft[k][kind] > kRounding * largest[kind];
    }
    if (open) undetermined.push_back(k);
  }
  return undetermined;
}

template std::vector<int> FindUndetermined(const Subproblem<ceres_costs::SE2>&);
template std::vector<int> FindUndetermined(const Subproblem<ceres_costs::SE3>&);
template std::vector<int> FindUndetermined(const Subproblem<ceres_costs::YawPose>&);

}  // namespace hpgo
