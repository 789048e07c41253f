// A cost of somebody's problem as a cost over poses of the group.
#pragma once

#include <vector>

#include "ceres/cost_function.h"
#include "ceres/manifold.h"
#include "hpgo/ceres/pose_codec.h"

namespace hpgo {

// Where a parameter block of the cost comes from.
struct BlockSource {
  int pose = -1;                   // which of the adapted cost's poses; -1: it is held
  int offset = 0;                  // in the numbers of the pose
  const double* values = nullptr;  // of one that is held: read at every evaluation
  const ceres::Manifold* manifold = nullptr;
  int size = 0;
  // Whether PlusJacobian is the derivative of Plus. Where it is not, the cost's Jacobians are made
  // for it (lifted), and only their product means something.
  bool true_jacobian = true;
};

// Parameter blocks: `poses` poses in the storage of G. Jacobians by the stored parameters, as
// FactorTerm::custom wants them. Borrows the cost, the held values and the manifolds. Evaluate is
// safe from several threads if that of the cost is.
template <typename G>
class AdaptedCost final : public ceres::CostFunction {
 public:
  AdaptedCost(const ceres::CostFunction* cost, const PoseCodec<G>& codec, int poses,
              std::vector<BlockSource> sources);

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  bool AddJacobian(const BlockSource& source, const double* values, const double* ambient,
                   const typename PoseCodec<G>::Jacobian& by_pose,
                   Eigen::Matrix<double, Eigen::Dynamic, G::kDof>* J) const;

  const ceres::CostFunction* cost_;
  PoseCodec<G> codec_;
  std::vector<BlockSource> sources_;
};

// True if PlusJacobian is the derivative of Plus at x, to what differencing can tell.
bool HasTrueJacobian(const ceres::Manifold& manifold, const double* x);

}  // namespace hpgo
