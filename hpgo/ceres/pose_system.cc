#include "hpgo/ceres/pose_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "Eigen/Core"
#include "ceres/cost_function.h"
#include "ceres/loss_function.h"
#include "hpgo/ceres/free_blocks.h"
#include "hpgo/solve/block_cholesky.h"
#include "hpgo/solve/damping.h"

namespace hpgo {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// D: the size of the Hessian's blocks. Poses of fewer degrees of freedom are padded with ones on
// the diagonal.
template <int D>
class PoseSystemOf final : public PoseSystem {
 public:
  PoseSystemOf(const ProblemView& problem, const PoseBlocks& poses)
      : problem_(problem), free_(problem, poses, D) {
    CopyValues();
    SortResiduals();
    FindPairs();
    cholesky_.Analyze(free_.num_poses(), pairs_);
  }

  double FixedCost() override {
    double sum = 0;
    for (const int r : fixed_) sum += Evaluate(r, values_.data());
    return sum / 2;
  }

  double Linearize() override {
    free_.UpdatePlusJacobians(values_);
    cholesky_.SetZero();
    gradient_.assign(static_cast<std::size_t>(free_.num_poses()) * D, 0.);
    double cost = 0;
    for (const Active& active : active_) cost += Add(active);
    bool finite = std::isfinite(cost) && free_.Measure(values_, gradient_, &gradient_norms_);
    for (int p = 0; p < free_.num_poses(); ++p) {
      Block block(cholesky_.Diagonal(p));
      finite &= block.allFinite();
      // Padding, and what nothing measures: it stays where it is.
      for (int c = 0; c < D; ++c) {
        if (block(c, c) == 0) block(c, c) = 1;
      }
    }
    return finite ? cost / 2 : kNaN;
  }

  double gradient_norm() const override { return gradient_norms_.norm; }
  double gradient_max_norm() const override { return gradient_norms_.max_norm; }
  bool Factorize(double damping) override { return cholesky_.Factor(damping); }

  double FindStep(double damping) override {
    step_.resize(gradient_.size());
    for (std::size_t k = 0; k < step_.size(); ++k) step_[k] = -gradient_[k];
    cholesky_.Solve(step_.data());
    scaled_.resize(step_.size());
    double descent = squared_ = 0;  // -g'd and d'D d
    for (int p = 0; p < free_.num_poses(); ++p) {
      const std::size_t at = static_cast<std::size_t>(p) * D;
      const Eigen::Map<const Vector> d(&step_[at]);
      Eigen::Map<Vector> scaled(&scaled_[at]);
      scaled = Block(cholesky_.Diagonal(p)).diagonal().cwiseProduct(d);
      descent -= d.dot(Eigen::Map<const Vector>(&gradient_[at]));
      squared_ += d.dot(scaled);
    }
    slope_ = -descent;
    damping_share_ = damping * squared_ / (descent + damping * squared_);
    return (descent + damping * squared_) / 2;
  }
  double damping_share() const override { return damping_share_; }

  double ShrinkingDamping(double damping) override {
    std::vector<double> shifted = scaled_;
    cholesky_.Solve(shifted.data());
    double slope = 0;  // d' D (H + damping D)^-1 D d
    for (std::size_t k = 0; k < shifted.size(); ++k) slope += scaled_[k] * shifted[k];
    return DampingToShrink(damping, squared_, slope);
  }

  double FindSecantStep(const SecantPairs& pairs) override {
    step_ = gradient_;
    pairs.Solve([this](double* x) { cholesky_.Solve(x); }, &step_);
    slope_ = 0;
    for (std::size_t k = 0; k < step_.size(); ++k) {
      step_[k] = -step_[k];
      slope_ += gradient_[k] * step_[k];
    }
    return -slope_ / 2;
  }
  const std::vector<double>& step() const override { return step_; }
  const std::vector<double>& gradient() const override { return gradient_; }
  double Slope() const override { return slope_; }
  double Try(double part) override {
    const bool moved = free_.Move(values_, step_, part, &trial_, &norms_);
    if (!moved || !std::isfinite(norms_.step)) return kNaN;
    double cost = 0;
    for (const Active& active : active_) cost += Evaluate(active.residual, trial_.data());
    return cost / 2;
  }

  double step_norm() const override { return norms_.step; }
  double value_norm() const override { return norms_.value; }
  void Accept() override { values_.swap(trial_); }
  void WriteBack() const override { free_.Write(values_); }
  void WriteBackInitial() const override { free_.Write(initial_); }

  int num_active_residual_blocks() const override { return static_cast<int>(active_.size()); }
  int num_active_residuals() const override { return num_residuals_; }
  int num_active_blocks() const override { return free_.num_blocks(); }
  int num_active_parameters() const override { return free_.num_parameters(); }
  int num_active_dof() const override { return free_.num_dof(); }
  int num_free_poses() const override { return free_.num_poses(); }

 private:
  using Block = Eigen::Map<Eigen::Matrix<double, D, D>>;
  using Vector = Eigen::Matrix<double, D, 1>;

  // A residual over one or two poses that move.
  struct Active {
    int residual = 0;
    int pose[2] = {-1, -1};
    int pair = -1;
    int row = 1;  // which of the two is the row of the pair's block
  };

  void CopyValues() {
    values_.resize(problem_.num_values());
    for (const BlockView& block : problem_.blocks()) {
      std::copy_n(block.values, block.size, values_.begin() + block.offset);
    }
    initial_ = values_;
  }

  void SortResiduals() {
    int max_residuals = 0, max_jacobian = 0;
    std::size_t max_blocks = 0;
    for (int r = 0; r < static_cast<int>(problem_.residuals().size()); ++r) {
      const ResidualView& view = problem_.residuals()[r];
      Active active;
      active.residual = r;
      int size = 0;
      for (int k = 0; k < view.count; ++k) {
        const int b = problem_.BlockOf(view, k);
        if (free_.PlaceOf(b) < 0) continue;
        size += problem_.blocks()[b].size;
        const int node = free_.PoseOf(b);
        if (active.pose[0] < 0) active.pose[0] = node;
        if (node != active.pose[0]) active.pose[1] = node;
      }
      max_blocks = std::max(max_blocks, static_cast<std::size_t>(view.count));
      max_residuals = std::max(max_residuals, view.cost->num_residuals());
      if (active.pose[0] < 0) {
        fixed_.push_back(r);
        continue;
      }
      max_jacobian = std::max(max_jacobian, size * view.cost->num_residuals());
      num_residuals_ += view.cost->num_residuals();
      active_.push_back(active);
    }
    residuals_.resize(max_residuals);
    jacobian_.resize(max_jacobian);
    local_[0].resize(static_cast<std::size_t>(max_residuals) * D);
    local_[1].resize(static_cast<std::size_t>(max_residuals) * D);
    parameters_.resize(max_blocks);
    jacobians_.resize(max_blocks);
  }

  void FindPairs() {
    std::vector<std::pair<std::pair<int, int>, int>> all;  // poses, place in active_
    for (int a = 0; a < static_cast<int>(active_.size()); ++a) {
      const auto [low, high] = std::minmax(active_[a].pose[0], active_[a].pose[1]);
      if (low >= 0) all.push_back({{low, high}, a});
    }
    std::sort(all.begin(), all.end());
    for (const auto& [ends, a] : all) {
      const std::pair<int, int> pair(ends.second, ends.first);
      if (pairs_.empty() || pairs_.back() != pair) pairs_.push_back(pair);
      active_[a].pair = static_cast<int>(pairs_.size()) - 1;
      active_[a].row = active_[a].pose[1] == pair.first;
    }
  }

  const double* const* Parameters(const ResidualView& view, const double* values) {
    for (int k = 0; k < view.count; ++k) {
      parameters_[k] = values + problem_.blocks()[problem_.BlockOf(view, k)].offset;
    }
    return parameters_.data();
  }

  // rho(|r|^2); NaN where the cost fails.
  double Evaluate(int r, const double* values) {
    const ResidualView& view = problem_.residuals()[r];
    if (!view.cost->Evaluate(Parameters(view, values), residuals_.data(), nullptr)) return kNaN;
    double rho[3] = {Residuals(view).squaredNorm(), 1, 0};
    if (view.loss != nullptr) view.loss->Evaluate(rho[0], rho);
    return rho[0];
  }

  Eigen::Map<const Eigen::VectorXd> Residuals(const ResidualView& view) const {
    return {residuals_.data(), view.cost->num_residuals()};
  }

  double Add(const Active& active) {
    const ResidualView& view = problem_.residuals()[active.residual];
    const int m = view.cost->num_residuals();
    double* J = jacobian_.data();
    for (int k = 0; k < view.count; ++k) {
      const int f = free_.PlaceOf(problem_.BlockOf(view, k));
      jacobians_[k] = f < 0 ? nullptr : J;
      if (f >= 0) J += m * free_[f].size;
    }
    if (!view.cost->Evaluate(Parameters(view, values_.data()), residuals_.data(),
                             jacobians_.data())) {
      return kNaN;
    }
    std::fill_n(local_[0].begin(), m * D, 0.);
    if (active.pair >= 0) std::fill_n(local_[1].begin(), m * D, 0.);
    for (int k = 0; k < view.count; ++k) {
      const int f = free_.PlaceOf(problem_.BlockOf(view, k));
      if (f < 0) continue;
      const int at = free_[f].step_at;
      const int side = at / D != active.pose[0];
      free_.ToLocal(m, f, jacobians_[k], &local_[side][at % D * m]);
    }
    double rho[3] = {Residuals(view).squaredNorm(), 1, 0};
    if (view.loss != nullptr) view.loss->Evaluate(rho[0], rho);
    // As Ceres' corrector: the second derivative counts only where it is positive.
    const double curvature = std::max(0., 2 * rho[2]);
    if (m == D) {
      Accumulate<D>(active, m, rho[1], curvature);
    } else {
      Accumulate<Eigen::Dynamic>(active, m, rho[1], curvature);
    }
    return rho[0];
  }

  // J'(w + c r r')J and J'w r of a residual of m rows.
  template <int M>
  void Accumulate(const Active& active, int m, double weight, double curvature) {
    using Jacobian = Eigen::Map<const Eigen::Matrix<double, M, D>>;
    const Eigen::Map<const Eigen::Matrix<double, M, 1>> r(residuals_.data(), m);
    const int sides = active.pair >= 0 ? 2 : 1;
    Vector Jr[2];
    for (int s = 0; s < sides; ++s) {
      const Jacobian J(local_[s].data(), m, D);
      Jr[s] = J.transpose().lazyProduct(r);
      Block block(cholesky_.Diagonal(active.pose[s]));
      block += weight * J.transpose().lazyProduct(J);
      if (curvature > 0) block += curvature * Jr[s] * Jr[s].transpose();
      Eigen::Map<Vector>(&gradient_[static_cast<std::size_t>(active.pose[s]) * D]) +=
          weight * Jr[s];
    }
    if (sides == 1) return;
    const Jacobian rows(local_[active.row].data(), m, D);
    const Jacobian columns(local_[1 - active.row].data(), m, D);
    Block block(cholesky_.OffDiagonal(active.pair));
    block += weight * rows.transpose().lazyProduct(columns);
    if (curvature > 0) block += curvature * Jr[active.row] * Jr[1 - active.row].transpose();
  }

  const ProblemView& problem_;
  FreeBlocks free_;
  std::vector<double> initial_, values_, trial_;  // of all blocks
  std::vector<Active> active_;
  std::vector<int> fixed_;
  int num_residuals_ = 0;
  std::vector<std::pair<int, int>> pairs_;
  BlockCholesky<D> cholesky_;
  std::vector<double> gradient_, step_;
  FreeBlocks::GradientNorms gradient_norms_;
  FreeBlocks::Norms norms_;
  std::vector<double> scaled_;  // D d with D = diag(H) and d the step; squared_: d' D d
  double squared_ = 0, slope_ = 0, damping_share_ = 0;
  // Workspace of one residual.
  std::vector<double> residuals_, jacobian_, local_[2];
  std::vector<const double*> parameters_;
  std::vector<double*> jacobians_;
};

}  // namespace

std::unique_ptr<PoseSystem> MakePoseSystem(const ProblemView& problem, const PoseBlocks& poses) {
  if (poses.max_dof <= 3) return std::make_unique<PoseSystemOf<3>>(problem, poses);
  if (poses.max_dof == 4) return std::make_unique<PoseSystemOf<4>>(problem, poses);
  return std::make_unique<PoseSystemOf<6>>(problem, poses);
}

}  // namespace hpgo
