// What solves a window, or a whole graph.
#pragma once

namespace hpgo {

enum class Engine {
  kCeres,  // ceres::Problem, SPARSE_NORMAL_CHOLESKY
  kBlock,  // Gauss-Newton / Levenberg-Marquardt on the blocks of the Hessian
};

}  // namespace hpgo
