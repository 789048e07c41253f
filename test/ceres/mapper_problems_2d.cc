#include <utility>

#include "Eigen/Cholesky"
#include "ceres/autodiff_cost_function.h"
#include "ceres/autodiff_manifold.h"
#include "hpgo/graph/edge_classes.h"
#include "test/ceres/mapper_problems.h"

namespace hpgo {
namespace {

using ceres_costs::NormalizeAngle;
using ceres_costs::SE2;

struct AngleFunctor {
  template <typename T>
  bool Plus(const T* x, const T* delta, T* y) const {
    *y = NormalizeAngle(T(*x + *delta));
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* d) const {
    *d = NormalizeAngle(T(*y - *x));
    return true;
  }
};
using AngleManifold = ceres::AutoDiffManifold<AngleFunctor, 1, 1>;

// S [R_i' (p_j - p_i) - t; yaw_j - yaw_i - theta].
struct RelativeError {
  template <typename T>
  bool operator()(const T* x_i, const T* y_i, const T* yaw_i, const T* x_j, const T* y_j,
                  const T* yaw_j, T* residuals) const {
    using std::cos;
    using std::sin;
    const T dx = *x_j - *x_i, dy = *y_j - *y_i, c = cos(*yaw_i), s = sin(*yaw_i);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(residuals);
    r(0) = c * dx + s * dy - z.data()[0];
    r(1) = -s * dx + c * dy - z.data()[1];
    r(2) = NormalizeAngle(T(*yaw_j - *yaw_i - z.data()[2]));
    r = S.template cast<T>() * r;
    return true;
  }
  template <typename T>
  bool operator()(const T* a, const T* b, T* residuals) const {
    return (*this)(a, a + 1, a + 2, b, b + 1, b + 2, residuals);
  }

  SE2 z;
  Eigen::Matrix3d S;
};

}  // namespace

const char* MapperName(Mapper2d mapper) {
  switch (mapper) {
    case Mapper2d::kCeresExample:
      return "CeresExample2d";
    case Mapper2d::kSlamToolbox:
      return "SlamToolbox";
    case Mapper2d::kRtabMap:
      return "RtabMap2d";
    case Mapper2d::kCartographer:
      return "Cartographer2d";
  }
  return "?";
}

std::unique_ptr<MapperProblem> MakeMapperProblem(Mapper2d mapper, const PoseGraph<SE2>& graph) {
  auto result = std::make_unique<MapperProblem>();
  const bool one_block = mapper == Mapper2d::kCartographer;
  ceres::Problem::Options options;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.enable_fast_removal = mapper == Mapper2d::kSlamToolbox;
  result->problem = std::make_unique<ceres::Problem>(options);
  ceres::Problem& problem = *result->problem;
  result->manifolds.push_back(std::make_unique<AngleManifold>());
  ceres::LossFunction* loss = nullptr;
  if (mapper == Mapper2d::kSlamToolbox) loss = new ceres::CauchyLoss(2);
  if (mapper == Mapper2d::kCartographer) loss = new ceres::HuberLoss(1);
  result->losses.emplace_back(loss);

  for (const GraphNode<SE2>& node : graph.nodes()) {
    result->storage.push_back({node.pose.data()[0], node.pose.data()[1], node.pose.data()[2]});
    result->sizes.push_back(one_block ? std::vector<int>{3} : std::vector<int>{1, 1, 1});
  }
  const std::vector<bool> loops = LoopClosures(graph);
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const GraphEdge<SE2>& edge = graph.edges()[e];
    RelativeError error{edge.measurement, edge.information.llt().matrixL()};
    double* a = result->Block(edge.i, 0);
    double* b = result->Block(edge.j, 0);
    if (one_block) {
      // Cartographer weighs translation and rotation by a number each.
      error.S = edge.information.diagonal().cwiseSqrt().asDiagonal();
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RelativeError, 3, 3, 3>(new RelativeError(error)),
          loops[e] ? loss : nullptr, a, b);
    } else {
      // The examples of Ceres, and RTAB-Map after them, whiten by L, not by its transpose.
      if (mapper == Mapper2d::kSlamToolbox) error.S = Eigen::Matrix3d(error.S.transpose());
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<RelativeError, 3, 1, 1, 1, 1, 1, 1>(
                                   new RelativeError(error)),
                               loss, a, a + 1, a + 2, b, b + 1, b + 2);
    }
  }
  for (std::size_t p = 0; p < graph.nodes().size(); ++p) {
    if (!problem.HasParameterBlock(result->Block(static_cast<int>(p), 0))) continue;
    if (!one_block) {
      problem.SetManifold(result->Block(static_cast<int>(p), 2), result->manifolds[0].get());
    }
  }
  for (std::size_t k = 0; k < result->sizes[0].size(); ++k) {
    problem.SetParameterBlockConstant(result->Block(0, static_cast<int>(k)));
  }
  return result;
}

}  // namespace hpgo
