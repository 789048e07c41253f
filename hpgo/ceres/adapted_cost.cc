#include "hpgo/ceres/adapted_cost.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "Eigen/QR"
#include "ceres_costs/manifolds.h"
#include "ceres_costs/se2.h"
#include "ceres_costs/se3.h"
#include "ceres_costs/yaw_pose.h"

namespace hpgo {
namespace {

using ceres_costs::SE2;
using ceres_costs::SE3;
using ceres_costs::YawPose;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// By central differences.
bool DifferencePlus(const ceres::Manifold& manifold, const double* x, Eigen::MatrixXd* J) {
  constexpr double kStep = 1e-5;
  const int size = manifold.AmbientSize(), tangent = manifold.TangentSize();
  J->resize(size, tangent);
  Eigen::VectorXd delta = Eigen::VectorXd::Zero(tangent), plus(size), minus(size);
  for (int c = 0; c < tangent; ++c) {
    delta(c) = kStep;
    if (!manifold.Plus(x, delta.data(), plus.data())) return false;
    delta(c) = -kStep;
    if (!manifold.Plus(x, delta.data(), minus.data())) return false;
    delta(c) = 0;
    J->col(c) = (plus - minus) / (2 * kStep);
  }
  return true;
}

}  // namespace

bool HasTrueJacobian(const ceres::Manifold& manifold, const double* x) {
  RowMajor said(manifold.AmbientSize(), manifold.TangentSize());
  Eigen::MatrixXd seen;
  if (!manifold.PlusJacobian(x, said.data()) || !DifferencePlus(manifold, x, &seen)) return false;
  constexpr double kTolerance = 1e-6;
  return (said - seen).cwiseAbs().maxCoeff() <=
         kTolerance * std::max(1., said.cwiseAbs().maxCoeff());
}

template <typename G>
AdaptedCost<G>::AdaptedCost(const ceres::CostFunction* cost, const PoseCodec<G>& codec, int poses,
                            std::vector<BlockSource> sources)
    : cost_(cost), codec_(codec), sources_(std::move(sources)) {
  set_num_residuals(cost->num_residuals());
  mutable_parameter_block_sizes()->assign(poses, G::kParams);
}

template <typename G>
bool AdaptedCost<G>::AddJacobian(const BlockSource& source, const double* values,
                                 const double* ambient,
                                 const typename PoseCodec<G>::Jacobian& by_pose,
                                 Eigen::Matrix<double, Eigen::Dynamic, G::kDof>* J) const {
  const Eigen::Map<const RowMajor> by_block(ambient, this->num_residuals(), source.size);
  const auto rows = by_pose.middleRows(source.offset, source.size);
  if (source.true_jacobian) {
    *J += by_block.lazyProduct(rows);
    return true;
  }
  // The tangent of the manifold by that of the group: from what Plus does, not from what it says.
  const int tangent = source.manifold->TangentSize();
  RowMajor said(source.size, tangent);
  Eigen::MatrixXd seen;
  if (!source.manifold->PlusJacobian(values, said.data()) ||
      !DifferencePlus(*source.manifold, values, &seen)) {
    return false;
  }
  *J += by_block * said * seen.householderQr().solve(Eigen::MatrixXd(rows));
  return true;
}

template <typename G>
bool AdaptedCost<G>::Evaluate(double const* const* parameters, double* residuals,
                              double** jacobians) const {
  constexpr int kMostPoses = 2;
  const int poses = static_cast<int>(this->parameter_block_sizes().size());
  double numbers[kMostPoses][G::kParams];
  G X[kMostPoses];
  for (int p = 0; p < poses; ++p) {
    X[p] = G(parameters[p]).Normalized();
    std::fill_n(numbers[p], G::kParams, 0.);
    codec_.Write(X[p], numbers[p]);
  }
  constexpr int kFew = 8;
  const double* few_blocks[kFew];
  double* few_jacobians[kFew];
  std::vector<const double*> many_blocks;
  std::vector<double*> many_jacobians;
  const double** blocks = few_blocks;
  double** block_jacobians = few_jacobians;
  const int count = static_cast<int>(sources_.size());
  if (count > kFew) {
    many_blocks.resize(count);
    many_jacobians.resize(count);
    blocks = many_blocks.data();
    block_jacobians = many_jacobians.data();
  }
  const int m = this->num_residuals();
  const auto wanted = [&](int p) {
    return p >= 0 && jacobians != nullptr && jacobians[p] != nullptr;
  };
  int total = 0;
  for (int k = 0; k < count; ++k) {
    const BlockSource& source = sources_[k];
    blocks[k] = source.pose < 0 ? source.values : numbers[source.pose] + source.offset;
    if (wanted(source.pose)) total += source.size;
  }
  if (jacobians == nullptr || total == 0) return cost_->Evaluate(blocks, residuals, nullptr);
  std::vector<double> ambient(static_cast<std::size_t>(total) * m);
  double* at = ambient.data();
  for (int k = 0; k < count; ++k) {
    block_jacobians[k] = wanted(sources_[k].pose) ? at : nullptr;
    if (block_jacobians[k] != nullptr) at += sources_[k].size * m;
  }
  if (!cost_->Evaluate(blocks, residuals, block_jacobians)) return false;
  for (int p = 0; p < poses; ++p) {
    if (!wanted(p)) continue;
    const typename PoseCodec<G>::Jacobian by_pose = codec_.WriteJacobian(X[p], numbers[p]);
    Eigen::Matrix<double, Eigen::Dynamic, G::kDof> J(m, G::kDof);
    J.setZero();
    for (int k = 0; k < count; ++k) {
      if (sources_[k].pose != p) continue;
      if (!AddJacobian(sources_[k], blocks[k], block_jacobians[k], by_pose, &J)) return false;
    }
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, G::kParams, Eigen::RowMajor>> out(
        jacobians[p], m, G::kParams);
    out = J.lazyProduct(ceres_costs::LocalCoordinatesJacobian(X[p]));
  }
  return true;
}

template class AdaptedCost<SE2>;
template class AdaptedCost<SE3>;
template class AdaptedCost<YawPose>;

}  // namespace hpgo
