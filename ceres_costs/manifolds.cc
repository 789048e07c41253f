#include "ceres_costs/manifolds.h"

namespace ceres_costs {
namespace {

template <typename G>
using AmbientByLocal = Eigen::Matrix<double, G::kParams, G::kDof, Eigen::RowMajor>;
template <typename G>
using LocalByAmbient = Eigen::Matrix<double, G::kDof, G::kParams, Eigen::RowMajor>;

}  // namespace

template <typename G>
bool ExponentialManifold<G>::Plus(const double* x, const double* delta,
                                  double* x_plus_delta) const {
  const G y = G(x).Plus(Eigen::Map<const typename G::Tangent>(delta));
  for (int k = 0; k < G::kParams; ++k) x_plus_delta[k] = y.data()[k];
  return true;
}

template <typename G>
bool ExponentialManifold<G>::Minus(const double* y, const double* x, double* y_minus_x) const {
  Eigen::Map<typename G::Tangent> out(y_minus_x);
  out = G(y).Minus(G(x));
  return true;
}

template <typename G>
bool PoseManifold<G>::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<AmbientByLocal<G>> out(jacobian);
  out = RetractionJacobian(G(x));
  return true;
}

template <typename G>
bool PoseManifold<G>::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<LocalByAmbient<G>> out(jacobian);
  out = LocalCoordinatesJacobian(G(x));
  return true;
}

template <typename G>
bool LocalPoseManifold<G>::PlusJacobian(const double*, double* jacobian) const {
  Eigen::Map<AmbientByLocal<G>> out(jacobian);
  out.setIdentity();
  return true;
}

template <typename G>
bool LocalPoseManifold<G>::MinusJacobian(const double*, double* jacobian) const {
  Eigen::Map<LocalByAmbient<G>> out(jacobian);
  out.setIdentity();
  return true;
}

template <typename G>
std::unique_ptr<ceres::Manifold> MakePoseManifold(JacobianKind kind) {
  if (kind == JacobianKind::kLocal) return std::make_unique<LocalPoseManifold<G>>();
  return std::make_unique<PoseManifold<G>>();
}

template class ExponentialManifold<SE2>;
template class ExponentialManifold<SE3>;
template class ExponentialManifold<YawPose>;
template class PoseManifold<SE2>;
template class PoseManifold<SE3>;
template class PoseManifold<YawPose>;
template class LocalPoseManifold<SE2>;
template class LocalPoseManifold<SE3>;
template class LocalPoseManifold<YawPose>;
template std::unique_ptr<ceres::Manifold> MakePoseManifold<SE2>(JacobianKind);
template std::unique_ptr<ceres::Manifold> MakePoseManifold<SE3>(JacobianKind);
template std::unique_ptr<ceres::Manifold> MakePoseManifold<YawPose>(JacobianKind);

}  // namespace ceres_costs
